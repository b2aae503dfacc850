"""The deformed faces of all cells, laid out for rays that look for the next wall."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.light.aligned import aligned
from magicsim.light.backend import mi
from magicsim.light.world.cell_topology import FACES, CellTopology, canonical_triangles

Array = npt.NDArray[np.float64]
PACKET = 4
"""Floats that are fetched together."""
NONE = 2**32 - 1
"""Stands for no cell."""
CONVEX_MM = 1e-5
"""Cells whose edges lie at most this deep below the plane beside them count as convex [mm]."""
NEVER = 2.0
"""Margin of cells in which no place is in front of all planes of their faces."""
FRAME = 16
"""Floats that describe a cell's frame."""


@dataclass(slots=True, kw_only=True)
class CellFaces:
    """Arrays on the renderer's side."""

    parts: int
    """Quads along an edge of a face."""
    patches: Any
    """Vertices of each face of each cell, `stride` floats a face [mm]."""
    stride: int
    frames: Any
    """Frames of each cell, `FRAME` floats: by rows the matrix into the cell's own frame, in which it is about [-1,
    1]^3; its centre [mm]; for each axis how far from its two faces, in that frame, a ray must end, see `_margins`; -inf
    where the cell is convex."""
    neighbours: Any
    """Cell across each face of each cell, mi.UInt32, `NONE` where there is none that the argument holds for."""
    face_of: Any
    """Face of each triangle of a cell, mi.UInt32."""
    triangles: Any
    """Mesh triangle of each canonical triangle of each face of a cell, mi.UInt32."""
    normals: Any
    """Outward normal of each canonical triangle of each face of each cell, `PACKET` floats a triangle."""

    @property
    def per_face(self) -> int:
        """Triangles of a face."""
        return 2 * self.parts**2

    @property
    def per_cell(self) -> int:
        """Triangles of a cell."""
        return FACES * self.per_face


def cell_faces(vertices: Array, topology: CellTopology) -> CellFaces:
    """Lays out the faces of a deformed grid.

    Args:
        vertices: Of all cells, cell after cell, shape (vertices, 3) [mm].
        topology: How a cell is put together.
    """
    cells = int(np.prod(topology.counts))
    corners = vertices.reshape(cells, -1, 3)
    faces, normals = corners[:, topology.corners], triangle_normals(corners, topology)
    stride = -(-3 * faces.shape[2] // PACKET) * PACKET
    patches = np.zeros((cells * FACES, stride), np.float32)
    patches[:, : 3 * faces.shape[2]] = faces.reshape(cells * FACES, -1)
    centres = faces.mean(2)
    axes = (centres[:, 1::2] - centres[:, ::2]) / 2
    inward = np.linalg.inv(axes.transpose(0, 2, 1))
    frames = np.zeros((cells, FRAME))
    frames[:, :9], frames[:, 9:12] = inward.reshape(cells, 9), centres.mean(1)
    dented = dents_mm(corners, normals, topology) > CONVEX_MM
    planes = _Planes.of(faces - frames[:, None, None, 9:12], topology.parts)
    frames[:, 12:15] = np.where(dented[:, None], _margins(planes, axes, inward), -np.inf)
    neighbours = topology.neighbours()
    facing = (neighbours, np.arange(FACES) ^ 1)
    free = ~dented[:, None] | _in_front(planes, faces[facing] - frames[:, None, None, 9:12])
    neighbours[~(free & free[facing])] = -1
    return CellFaces(
        parts=topology.parts,
        patches=mi.Float(aligned(patches, np.float32).ravel()),
        stride=stride,
        frames=mi.Float(aligned(frames, np.float32).ravel()),
        neighbours=mi.UInt32(aligned(np.where(neighbours < 0, NONE, neighbours), np.uint32).ravel()),
        face_of=mi.UInt32(topology.face_of.astype(np.uint32)),
        triangles=mi.UInt32(topology.triangles.astype(np.uint32).ravel()),
        normals=mi.Float(aligned(np.pad(normals, ((0, 0), (0, 0), (0, 1))), np.float32).ravel()),
    )


def triangle_normals(corners: Array, topology: CellTopology) -> npt.NDArray[np.float32]:
    """Outward unit normals of the canonical triangles of each face of each cell, shape (cells, triangles, 3).

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        topology: How a cell is put together.
    """
    a, b, c = (np.asarray(corners[:, index], np.float32) for index in _triangles(topology).T)
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-30), np.float32)


def dents_mm(corners: Array, normals: npt.NDArray[np.float32], topology: CellTopology) -> Array:
    """How far each cell is from convex: the largest height of a triangle's tip over the plane of the one beside it.

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        normals: See `triangle_normals`.
        topology: How a cell is put together.

    Returns:
        Shape (cells,) [mm].
    """
    triangles = _triangles(topology)
    plane, tip = _beside(triangles)
    above = np.asarray(corners[:, tip] - corners[:, triangles[plane, 0]], np.float32)
    return np.asarray(np.einsum("cti,cti->ct", normals[:, plane], above).max(1), np.float64)


def _triangles(topology: CellTopology) -> npt.NDArray[np.int64]:
    return np.asarray(topology.corners[:, canonical_triangles(topology.parts)].reshape(-1, 3))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Planes:
    """Planes of the triangles of all faces; coordinates first, so that each is one contiguous array."""

    points: Array
    """Vertices of each face from its cell's centre, shape (3, cells, 6, vertices of a face) [mm]."""
    normals: Array
    """Outward, of any length, shape (3, cells, 6, triangles of a face)."""
    heights: Array
    """Heights of the planes along their normals, shape (cells, 6, triangles of a face)."""

    @classmethod
    def of(cls, faces: Array, parts: int) -> Self:
        """Planes of faces, shape (cells, 6, vertices of a face, 3) [mm]."""
        points = _coordinates_first(faces)
        a, b, c = (points[..., index] for index in canonical_triangles(parts).T)
        u, v = b - a, c - a
        normals = np.stack([u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)])
        return cls(points=points, normals=normals, heights=_dot(normals, a))


def _margins(planes: _Planes, axes: Array, inward: Array) -> Array:
    """Distance from the faces of each axis, in the cell's frame, beyond which a place is behind all planes of them.

    Args:
        planes: Of the triangles.
        axes: Axes of each cell's frame as rows, shape (cells, 3, 3) [mm].
        inward: Matrix into the frame, shape (cells, 3, 3).

    Returns:
        Shape (cells, 3), in units of half a cell; `NEVER` in all of a cell where one of them leaves no room.
    """
    # Transformed as planes are, so that a place x in the frame is behind one where slopes @ x < height.
    slopes = [_dot(planes.normals, axes[:, axis].T[:, :, None, None]) for axis in range(3)]
    reach = np.stack(
        [np.abs(_dot(planes.points, row.T[:, :, None, None])).max((1, 2)) for row in np.moveaxis(inward, 1, 0)]
    )
    margins = np.empty((len(axes), 3))
    for axis in range(3):
        pair = slice(2 * axis, 2 * axis + 2)
        along = slopes[axis][:, pair] * np.array([-1, 1])[:, None]
        beside = (
            sum(np.abs(slopes[other][:, pair]) for other in range(3) if other != axis) * reach.max(0)[:, None, None]
        )
        steep = along <= 0
        lowest = (planes.heights[:, pair] - beside) / np.where(steep, 1.0, along)
        margins[:, axis] = np.where(steep, NEVER, 1 - lowest).max((1, 2))
    return np.where((margins >= 1).any(1, keepdims=True), NEVER, margins)


def _in_front(planes: _Planes, others: Array) -> npt.NDArray[np.bool_]:
    """Whether all of another face lies outside all planes of a face's triangles, so that no ray to it meets them.

    Args:
        planes: Of the triangles of each face.
        others: Vertices of the other face from the same centre, shape (cells, 6, vertices of a face, 3) [mm].
    """
    places = _coordinates_first(others)
    lowest = np.full_like(planes.heights, np.inf)
    for vertex in range(places.shape[3]):
        np.minimum(lowest, _dot(planes.normals, places[..., vertex, None]), out=lowest)
    return np.asarray((lowest > planes.heights).all(2))


def _coordinates_first(places: Array) -> Array:
    return np.ascontiguousarray(np.moveaxis(places, -1, 0))


def _dot(one: Array, other: Array) -> Array:
    return np.asarray(one[0] * other[0] + one[1] * other[1] + one[2] * other[2])


def _beside(triangles: npt.NDArray[np.int64]) -> tuple[list[int], list[int]]:
    """For each edge: a triangle, and the tip of the other triangle of that edge."""
    turned = [np.roll(triangles, -turn, axis=1).tolist() for turn in range(3)]
    owner = {(a, b): (number, tip) for corners in turned for number, (a, b, tip) in enumerate(corners)}
    pairs = [(owner[edge][0], owner[edge[::-1]][1]) for edge in owner if edge[0] < edge[1]]
    return [plane for plane, _ in pairs], [tip for _, tip in pairs]
