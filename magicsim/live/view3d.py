"""The block and the object in 3D, and the handle by which the object is dragged."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import viser

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.live.sight import Scenery
from magicsim.robot.workspace import Workspace

Colors = npt.NDArray[np.uint8]
STILL, MOVED = np.array([120.0, 132.0, 150.0]), np.array([205.0, 60.0, 20.0])
"""Colour of a node at rest and of one that has moved by `FULL_MM`, RGB 0..255."""
FULL_MM = 0.5
"""Displacement of the strongest colour [mm]."""


def lattice_edges(lattice: Lattice) -> Index:
    """Pairs of neighbouring nodes, each once.

    Nodes are numbered x fastest and z slowest. Edges along the sensor's axis are left out inside the block, where they
    would hide the layers.

    Returns:
        Shape (edges, 2).
    """
    counts = tuple(len(planes) for planes in lattice.planes_mm)
    number = np.arange(len(lattice.nodes_mm)).reshape(counts[::-1])
    along_x = np.stack([number[:, :, :-1], number[:, :, 1:]], -1).reshape(-1, 2)
    along_y = np.stack([number[:, :-1], number[:, 1:]], -1).reshape(-1, 2)
    rim = np.zeros(number.shape[1:], bool)
    rim[[0, -1], :] = rim[:, [0, -1]] = True
    along_z = np.stack([number[:-1, rim], number[1:, rim]], -1).reshape(-1, 2)
    return np.concatenate([along_x, along_y, along_z])


def segment_colors(displacement_mm: Array, edges: Index) -> Colors:
    """Colour of both ends of each edge, from how far its nodes have moved, uint8 of shape (edges, 2, 3).

    Args:
        displacement_mm: Of each node, shape (nodes,) [mm].
        edges: From `lattice_edges`.
    """
    share = np.clip(displacement_mm / FULL_MM, 0, 1)[edges][..., None]
    return np.asarray(STILL + share * (MOVED - STILL), np.uint8)


Dragged = Callable[[float, float, float], None]
"""Takes x, y and the height of the object's origin above its place at a gap of 0 [mm]."""
LINE_MM, HANDLE_MM = 0.08, 6.0
GREY_TONE = 1 / 2.2


class View3D:
    """What viser's scene shows; handles of an earlier block are replaced."""

    def __init__(self, server: viser.ViserServer, space: Workspace, dragged: Dragged) -> None:
        """An empty scene, looked at from below the contact face."""
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
        """Puts another block and object in place."""
        self._edges = lattice_edges(lattice)
        points = lattice.nodes_mm[self._edges].astype(np.float32)
        colors = segment_colors(np.zeros(len(lattice.nodes_mm)), self._edges)
        self._lines = self._server.scene.add_line_segments("/lattice", points, colors, thickness=LINE_MM)
        if thing is not None:
            tone = tuple(round(255 * value**GREY_TONE) for value in color)
            self._mesh = self._server.scene.add_mesh_simple(
                "/object", thing.vertices.astype(np.float32), thing.faces.astype(np.uint32), color=tone, opacity=0.55
            )

    def show(self, shape: Scenery, gap_mm: float) -> None:
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
