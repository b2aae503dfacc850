"""What both passes ask of a loaded scene: its shapes by their role, its lights, its cells, its object."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import OfMesh, aligned, mi
from magicsim.light.cells.cell_faces import CellFaces, cell_faces
from magicsim.light.cells.cell_topology import CellTopology
from magicsim.light.flaws.scatterers import Scatterers, placing
from magicsim.light.world import names
from magicsim.light.world.coated_face import CoatedFace
from magicsim.light.world.coating import FaceCoating
from magicsim.light.world.irradiance import SMOOTHING_MM, IrradianceKernel, irradiance_kernel, widened
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.room_light import Beam, room_beams, surroundings
from magicsim.light.world.shapes import Shapes, lights, mesh_of, shape_named, wetted
from magicsim.scenes.rig import Rig

NOTHING = SurfaceMesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))
"""Stands for an absent object, so that arrays have a size."""


@dataclass(frozen=True, kw_only=True)
class GridState:
    """What is known of the cells as they are deformed."""

    mesh: SurfaceMesh
    """Faces are cell-major."""
    cells: int
    centres_mm: Array
    """Mean of the vertices of each cell, shape (cells, 3) [mm]."""
    faces: CellFaces | None
    """For `next_hit`; None to search among all triangles for every hit."""

    @cached_property
    def volumes_mm3(self) -> Array:
        """Volume of each cell by the divergence theorem, shape (cells,) [mm3]."""
        corners = self.mesh.vertices[self.mesh.faces].reshape(self.cells, -1, 3, 3)
        corners = corners - corners[:, :1, :1]
        return np.asarray(np.einsum("cti,cti->c", corners[:, :, 0], np.cross(corners[:, :, 1], corners[:, :, 2])) / 6)


class Inventory:
    """Keeps from one render to the next what has not changed."""

    def __init__(
        self, scene: Any, block: Mapping[str, Any], elastomer: Elastomer, rig: Rig, own_mesh: SurfaceMesh | None
    ) -> None:
        """Inventory of a scene that keeps its block in a group, out of sight.

        The object is in its own frame: its smoothing must not depend on the pose that is rendered first.
        """
        self._scene, self._body, self._infill = scene, block[names.BODY], block.get(names.INFILL)
        self.environment = surroundings(scene.environment(), rig)
        """What shines from all around, or None."""
        self._object_mesh = own_mesh
        self._triangles_per_cell = max(elastomer.triangles_per_cell, 1)
        self._topology, self._fused = CellTopology.of(elastomer), (fused := elastomer.fused)
        self._grid, self._scatterers = OfMesh(), OfMesh()
        self._kernels: dict[tuple[bool, int], IrradianceKernel] = {}
        self._openings = mi.UInt32(aligned(fused.beyond, np.uint32)) if fused is not None else None
        self._coating, self._placing = FaceCoating.of(elastomer, rig), placing(elastomer)

    def shapes(self, outside: Outside | None = None, room: Any = None) -> Shapes:
        """The scene's shapes by their role; the object is from `outside` if something stands there."""
        grid = self.grid()
        return Shapes(
            body=self._body,
            infill=self._infill,
            object=outside.object if outside is not None else shape_named(self._scene, names.OBJECT),
            triangles_per_cell=self._triangles_per_cell,
            faces=grid.faces if grid is not None else None,
            openings=self._openings,
            outside=outside.scene if outside is not None and outside.is_there else None,
            coating=self._coating.on(self._body, self._scene) if self._coating is not None else None,
            environment=self.environment,
            room=room,
            scatterers=found[0] if (found := self._flaws()) is not None else None,
        )

    def coated_face(self) -> CoatedFace | None:
        """The face under an opaque coat, None where it is bare or partly so."""
        return self._coating.face(self._body) if self._coating is not None and self._coating.is_opaque else None

    def grid(self) -> GridState | None:
        """The cells as they are deformed, or None without a grid; computed when their vertices were replaced.

        Hits are looked for in the cell that a ray is in; in and beside fused cells, and all of them where something may
        reach into the grid, as LED strips do under a thin skin, among all triangles.
        """
        found: GridState | None = self._grid.of(self._infill, self._deformed) if self._infill is not None else None
        return found

    def _flaws(self) -> tuple[Scatterers, Array] | None:
        """Scatterers of the print in the cells as they are, and the air in each; None where it is clean."""
        return self._scatterers.of(self._infill, self._placing) if self._placing is not None else None

    def _deformed(self, infill: Any) -> GridState:
        mesh, box, pairs = mesh_of(infill), infill.bbox(), None
        cells = len(mesh.faces) // self._triangles_per_cell
        if self._fused is not None:
            mesh, pairs = SurfaceMesh(vertices=mesh.vertices, faces=self._fused.closed), self._fused.pairs
        others = [shape for shape in self._scene.shapes() if shape.id() not in names.AROUND_CELLS]
        alone = not any(box.overlaps(shape.bbox()) for shape in others)
        return GridState(
            mesh=mesh,
            cells=cells,
            centres_mm=mesh.vertices.reshape(cells, -1, 3).mean(1),
            faces=cell_faces(mesh.vertices, self._topology, pairs) if self._topology is not None and alone else None,
        )

    def volumes_mm3(self) -> Array:
        """Volumes of the infill in the cells, shape (cells, 1) [mm3]; 1 without a grid."""
        grid = self.grid()
        if grid is None:
            return np.ones((1, 1))
        flaws = self._flaws()
        air = flaws[1] if flaws is not None else 0.0
        return np.asarray(grid.volumes_mm3[:, None] - air)

    def centres_mm(self) -> Array:
        """Centres of the cells, shape (cells, 3) [mm]; none without a grid."""
        grid = self.grid()
        return grid.centres_mm if grid is not None else np.zeros((0, 3))

    def irradiance(self, shapes: Shapes, landed: Array) -> Array:
        """Irradiance of the object's triangles from the flux on each, both of shape (triangles, channels)."""
        return self._kernel(shapes).irradiance(landed, wetted(self._scene, shapes))

    def gathered_irradiance(self, shapes: Shapes, flux: Array, areas_mm2: Array, otherwise: Array) -> Array:
        """Irradiance of the object's triangles from samples, see `IrradianceKernel.gathered` and `widened`."""
        mesh, wet = mesh_of(shapes.object), wetted(self._scene, shapes)
        away_mm = -mesh.vertices[mesh.faces, 2].mean(1)

        @cache
        def gathered(doublings: int) -> Array:
            return self._kernel(shapes, doublings).gathered(flux, areas_mm2, wet, otherwise)

        return widened(gathered, away_mm)

    def lights(self, outside: Outside | None = None) -> list[str]:
        """Names of the lights, the flashlight from outside if one is there."""
        is_there = outside is not None and outside.flashlight is not None
        return lights(self._scene) + ([names.FLASHLIGHT] if is_there else [])

    def emitter(self, name: str, outside: Outside | None = None) -> Any:
        """The emitter of a light by its name."""
        if outside is not None and name == names.FLASHLIGHT:
            return outside.flashlight.emitter()
        return self.environment if name == names.ENVIRONMENT else shape_named(self._scene, name).emitter()

    def beams(self, outside: Outside | None = None) -> list[Beam]:
        """The beams in which light of the room comes, see `room_beams`."""
        moving = {names.OBJECT, names.GHOST, names.FLASHLIGHT}
        boxes = {shape.id(): shape.bbox() for shape in self._scene.shapes()}
        sensor = mi.ScalarBoundingBox3f()
        for name, box in boxes.items():
            if name not in moving:
                sensor.expand(box)
        there = outside.object if outside is not None else None
        target = there.bbox() if there is not None else boxes.get(names.OBJECT)
        others = [box for name, box in boxes.items() if name in moving]
        if outside is not None:
            others.append(outside.scene.bbox())
        return room_beams(sensor, boxes[names.PLACE], boxes.get(names.HOUSING), target, others)

    def _kernel(self, shapes: Shapes, doublings: int = 0) -> IrradianceKernel:
        present = shapes.object is not None
        key = (present, doublings)
        if key not in self._kernels:  # The object is rigid, so once is enough.
            seen = mesh_of(shapes.object) if present else NOTHING
            mesh = (self._object_mesh if present else None) or seen
            self._kernels[key] = irradiance_kernel(mesh, SMOOTHING_MM * 2**doublings)
        return self._kernels[key]
