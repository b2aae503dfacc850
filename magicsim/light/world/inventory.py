"""What both passes ask of a loaded scene: its shapes by their role, its lights, its cells, its object."""

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import mi
from magicsim.light.flaws.held_scatterers import HeldScatterers
from magicsim.light.transport.coating import FaceCoating
from magicsim.light.world.cell_topology import CellTopology
from magicsim.light.world.grid_state import GridState, GridStates
from magicsim.light.world.irradiance import SMOOTHING_MM, IrradianceKernel, irradiance_kernel, widened
from magicsim.light.world.names import BODY, ENVIRONMENT, FLASHLIGHT, GHOST, HOUSING, INFILL, OBJECT, PLACE
from magicsim.light.world.outside import Outside
from magicsim.light.world.room_light import Beam, room_beams
from magicsim.light.world.shapes import Shapes, lights, mesh_of, shape_named, wetted

FloatArray = npt.NDArray[np.float64]
NOTHING = SurfaceMesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))
"""Stands for an absent object, so that arrays have a size."""


class Inventory:
    """Keeps from one render to the next what has not changed."""

    def __init__(self, triangles_per_cell: int) -> None:
        """For an infill of disjoint cells."""
        self.triangles_per_cell = triangles_per_cell
        self._object_mesh: SurfaceMesh | None = None
        self._grids = GridStates(triangles_per_cell)
        self._kernels: dict[tuple[bool, int], IrradianceKernel] = {}
        self._block: dict[str, Any] = {}
        self._coating: FaceCoating | None = None
        self._scatterers: HeldScatterers | None = None

    def hold(self, body: Any, infill: Any) -> None:
        """Takes the shapes of a block that a scene keeps in a group, out of sight.

        Args:
            body: Its surface.
            infill: All cells, or None without a grid.
        """
        self._block = {BODY: body, INFILL: infill}

    def know(
        self,
        topology: CellTopology | None,
        object_mesh: SurfaceMesh | None,
        coating: FaceCoating | None = None,
        scatterers: HeldScatterers | None = None,
    ) -> None:
        """Takes what a loaded scene does not tell.

        Args:
            topology: How the cells are put together: hits are then looked for in the cell that a ray is in.
            object_mesh: The object in its own frame: its smoothing must not depend on the pose that is rendered first.
            coating: Of the contact face, or None where it is bare.
            scatterers: Bubbles and flakes, or None where the print is clean.
        """
        self._coating, self._scatterers = coating, scatterers
        self._grids.topology = topology
        self._object_mesh = object_mesh

    def shapes(self, scene: Any, outside: Outside | None = None) -> Shapes:
        """The scene's shapes by their role, the object from outside if something is there."""
        grid, body = self.grid(scene), self._in_block(scene, BODY)
        return Shapes(
            body=body,
            infill=self._in_block(scene, INFILL),
            object=outside.object if outside is not None else shape_named(scene, OBJECT),
            triangles_per_cell=self.triangles_per_cell,
            faces=grid.faces if grid is not None else None,
            outside=outside.scene if outside is not None and outside.object is not None else None,
            coating=self._coating.on(body) if self._coating is not None else None,
            scatterers=self._scatterers.on(self._in_block(scene, INFILL)) if self._scatterers is not None else None,
        )

    def grid(self, scene: Any) -> GridState | None:
        """The cells as they are deformed, or None without a grid."""
        infill = self._in_block(scene, INFILL)
        # The housing stands around the block, so that its box tells nothing.
        known = {BODY, INFILL, PLACE, OBJECT, GHOST, HOUSING}
        strangers = [shape for shape in scene.shapes() if shape.id() not in known]
        return self._grids.of(infill, strangers) if infill is not None else None

    def volumes_mm3(self, scene: Any) -> FloatArray:
        """Volumes of the infill in the cells, shape (cells, 1) [mm3]; 1 without a grid."""
        grid = self.grid(scene)
        if grid is None:
            return np.ones((1, 1))
        held = self._scatterers
        air = held.air_mm3(self._in_block(scene, INFILL)) if held is not None else 0.0
        return np.asarray(grid.volumes_mm3[:, None] - air)

    def centres_mm(self, scene: Any) -> FloatArray:
        """Centres of the cells, shape (cells, 3) [mm]; none without a grid."""
        grid = self.grid(scene)
        return grid.centres_mm if grid is not None else np.zeros((0, 3))

    def irradiance(self, scene: Any, shapes: Shapes, landed: FloatArray) -> FloatArray:
        """Irradiance of the object's triangles from the flux on each, both of shape (triangles, channels)."""
        return self._kernel(shapes).irradiance(landed, wetted(scene, shapes))

    def gathered_irradiance(
        self, scene: Any, shapes: Shapes, flux: FloatArray, areas_mm2: FloatArray, otherwise: FloatArray
    ) -> FloatArray:
        """Irradiance of the object's triangles from samples, see `IrradianceKernel.gathered` and `widened`."""
        mesh, wet = mesh_of(shapes.object), wetted(scene, shapes)
        away_mm = -mesh.vertices[mesh.faces, 2].mean(1)

        @cache
        def gathered(doublings: int) -> FloatArray:
            return self._kernel(shapes, doublings).gathered(flux, areas_mm2, wet, otherwise)

        return widened(gathered, away_mm)

    def _in_block(self, scene: Any, name: str) -> Any:
        return self._block[name] if self._block else shape_named(scene, name)

    def _kernel(self, shapes: Shapes, doublings: int = 0) -> IrradianceKernel:
        present = shapes.object is not None
        key = (present, doublings)
        if key not in self._kernels:  # The object is rigid, so once is enough.
            seen = mesh_of(shapes.object) if present else NOTHING
            mesh = (self._object_mesh if present else None) or seen
            self._kernels[key] = irradiance_kernel(mesh, SMOOTHING_MM * 2**doublings)
        return self._kernels[key]


def light_names(scene: Any, outside: Outside | None = None) -> list[str]:
    """Names of the lights, the flashlight from outside if one is there."""
    return lights(scene) + ([FLASHLIGHT] if outside is not None and outside.flashlight is not None else [])


def emitter_of(scene: Any, name: str, outside: Outside | None = None) -> Any:
    """The emitter of a light by its name."""
    if outside is not None and name == FLASHLIGHT:
        return outside.flashlight.emitter()
    return scene.environment() if name == ENVIRONMENT else shape_named(scene, name).emitter()


def beams_of(scene: Any, outside: Outside | None = None) -> list[Beam]:
    """The beams in which light of the room comes, see `room_beams`."""
    moving = {OBJECT, GHOST, FLASHLIGHT}
    boxes = {shape.id(): shape.bbox() for shape in scene.shapes()}
    sensor = mi.ScalarBoundingBox3f()
    for name, box in boxes.items():
        if name not in moving:
            sensor.expand(box)
    target = outside.object.bbox() if outside is not None and outside.object is not None else boxes.get(OBJECT)
    others = [box for name, box in boxes.items() if name in moving]
    if outside is not None:
        others.append(outside.scene.bbox())
    block = boxes.get(PLACE, boxes.get(BODY))
    return room_beams(sensor, block, boxes.get(HOUSING), target, others)
