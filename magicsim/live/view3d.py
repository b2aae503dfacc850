"""The block and the object in 3D, and the handle by which the object is dragged."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import viser

from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.live.lattice_lines import lattice_edges, segment_colors
from magicsim.live.sight import Shape
from magicsim.robot.workspace import Workspace

Dragged = Callable[[float, float, float], None]
"""Takes x, y and the height of the object's origin above its place at a gap of 0 [mm]."""
LINE_MM, HANDLE_MM = 0.08, 6.0
GREY_TONE = 1 / 2.2


class View3D:
    """What viser's scene shows; handles of an earlier block are replaced."""

    def __init__(self, server: viser.ViserServer, space: Workspace, dragged: Dragged) -> None:
        """An empty scene, looked at from below the contact face.

        Args:
            server: The window's.
            space: Where the object may go.
            dragged: Told when the handle moves.
        """
        self._server, self._dragged = server, dragged
        server.scene.set_up_direction("+z")
        server.initial_camera.position = (21.0, -33.0, -18.0)
        server.initial_camera.look_at = (0.0, 0.0, 0.5)
        self._edges: npt.NDArray[np.int64] | None = None
        self._lines: viser.LineSegmentsHandle | None = None
        self._mesh: viser.MeshHandle | None = None
        self._is_held = False
        low, high = space.gap_mm
        self._handle = server.scene.add_transform_controls(
            "/handle",
            scale=HANDLE_MM,
            disable_rotations=True,
            translation_limits=(space.x_mm, space.y_mm, (-high - HANDLE_MM, -low + HANDLE_MM)),
            depth_test=False,
            visible=False,
        )
        self._handle.on_update(lambda event: self._moved(event.client_id, str(event.phase)))

    def show_block(self, lattice: Lattice, thing: SurfaceMesh | None, color: tuple[float, float, float]) -> None:
        """Puts another block and object in place.

        Args:
            lattice: As it is solved.
            thing: The object in its own frame.
            color: Its reflectance in linear RGB, 0..1.
        """
        self._edges = lattice_edges(lattice)
        points = lattice.nodes_mm[self._edges].astype(np.float32)
        colors = segment_colors(np.zeros(len(lattice.nodes_mm)), self._edges)
        self._lines = self._server.scene.add_line_segments("/lattice", points, colors, thickness=LINE_MM)
        if thing is not None:
            tone = tuple(round(255 * value**GREY_TONE) for value in color)
            self._mesh = self._server.scene.add_mesh_simple(
                "/object", thing.vertices.astype(np.float32), thing.faces.astype(np.uint32), color=tone, opacity=0.55
            )

    def show(self, shape: Shape, gap_mm: float) -> None:
        """Moves everything to a sight's shape.

        Args:
            shape: Lattice and object.
            gap_mm: Of the object [mm].
        """
        if self._lines is not None and self._edges is not None:
            with self._server.atomic():
                self._lines.points = shape.nodes_mm[self._edges].astype(np.float32)
                self._lines.colors = segment_colors(shape.displacement_mm, self._edges)
        is_there = shape.object_position_mm is not None and shape.object_rotation is not None
        self._handle.visible = is_there
        if self._mesh is None:
            return
        self._mesh.visible = is_there
        if shape.object_position_mm is None or shape.object_rotation is None:
            return
        self._mesh.position = shape.object_position_mm
        self._mesh.wxyz = quaternion(shape.object_rotation)
        if not self._is_held:
            x, y, _ = shape.object_position_mm
            self._handle.position = (float(x), float(y), -gap_mm)

    def _moved(self, client: int | None, phase: str) -> None:
        if client is None:  # the window itself has moved it
            return
        self._is_held = phase != "end"
        x, y, z = (float(value) for value in self._handle.position)
        self._dragged(x, y, z)


def quaternion(rotation: npt.NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a rotation matrix of shape (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(w), float(x), float(y), float(z)
