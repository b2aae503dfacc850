"""The deformed faces of all cells, laid out for rays that look for the next wall.

Kernels find the dents that a cell's faces have, how far from them a ray must end so that it has met none, and whether
another face lies in front of all planes of one. Only cells with dents are asked for more than that.
"""

from dataclasses import dataclass
from typing import Any

# ruff: noqa: ANN001, ANN201, ANN202 -- numba infers the types of the kernels.
import numpy as np

from magicsim.arrays import Array, Index
from magicsim.kernels import kernel
from magicsim.light.backend import aligned, floats, mi
from magicsim.light.cells.cell_topology import FACES, CellTopology, canonical_triangles

NEVER = 2.0
"""Margin of cells in which no place is in front of all planes of their faces."""
TINY = np.float32(1e-30)
PACKET = 4
"""Floats that are fetched together."""
NONE = 2**32 - 1
"""Stands for no cell."""
CONVEX_MM = 1e-5
"""Cells whose edges lie at most this deep below the plane beside them count as convex [mm]."""
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
    1]^3; its centre [mm]; for each axis how far from its two faces, in that frame, a ray must end, see
    `dented_cells`; -inf where the cell is convex."""
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


def cell_faces(vertices: Array, topology: CellTopology, fused: Index | None = None) -> CellFaces:
    """Lays out the faces of a deformed grid, cell after cell; no argument holds for those of `fused` cells."""
    cells = int(np.prod(topology.counts))
    corners = vertices.reshape(cells, -1, 3)
    canonical = canonical_triangles(topology.parts)
    faces, triangles = corners[:, topology.corners], topology.corners[:, canonical].reshape(-1, 3)
    normals = outward_normals(corners, triangles)
    stride = -(-3 * faces.shape[2] // PACKET) * PACKET
    patches = np.zeros((cells * FACES, stride), np.float32)
    patches[:, : 3 * faces.shape[2]] = faces.reshape(cells * FACES, -1)
    centres = faces.mean(2)
    axes = (centres[:, 1::2] - centres[:, ::2]) / 2
    inward = np.linalg.inv(axes.transpose(0, 2, 1))
    frames = np.zeros((cells, FRAME))
    frames[:, :9], frames[:, 9:12] = inward.reshape(cells, 9), centres.mean(1)
    dented = largest_dents_mm(corners, normals, triangles, *_beside(triangles)) > CONVEX_MM
    neighbours = topology.neighbours()
    frames[:, 12:15], free = dented_cells(faces, canonical, dented, frames[:, 9:12], axes, inward, neighbours)
    neighbours[~(free & free[neighbours, np.arange(FACES) ^ 1])] = -1
    if fused is not None:
        frames[fused, 12:15], neighbours[fused] = NEVER, -1
        neighbours[np.isin(neighbours, fused)] = -1
    return CellFaces(
        parts=topology.parts,
        patches=floats(patches),
        stride=stride,
        frames=floats(frames),
        neighbours=mi.UInt32(aligned(np.where(neighbours < 0, NONE, neighbours), np.uint32).ravel()),
        face_of=mi.UInt32(topology.face_of.astype(np.uint32)),
        triangles=mi.UInt32(topology.triangles.astype(np.uint32).ravel()),
        normals=floats(normals),
    )


def _beside(triangles: Index) -> tuple[Index, Index]:
    """For each edge: a triangle, and the tip of the other triangle of that edge."""
    turned = [np.roll(triangles, -turn, axis=1).tolist() for turn in range(3)]
    owner = {(a, b): (number, tip) for corners in turned for number, (a, b, tip) in enumerate(corners)}
    pairs = [(owner[edge][0], owner[edge[::-1]][1]) for edge in owner if edge[0] < edge[1]]
    planes, tips = np.array(pairs, np.int64).T
    return planes, tips


@kernel()
def outward_normals(corners, triangles):  # type: ignore[no-untyped-def]
    """Outward unit normals of the triangles of each cell and a zero beside each, shape (cells, triangles, 4), float32.

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        triangles: Vertices of its triangles, shape (triangles, 3).
    """
    normals = np.zeros((len(corners), len(triangles), 4), np.float32)
    u, v, n = np.empty(3, np.float32), np.empty(3, np.float32), np.empty(3, np.float32)
    for cell in range(len(corners)):
        for t in range(len(triangles)):
            a, b, c = triangles[t]
            for k in range(3):
                first = np.float32(corners[cell, a, k])
                u[k] = np.float32(corners[cell, b, k]) - first
                v[k] = np.float32(corners[cell, c, k]) - first
            for k in range(3):
                n[k] = u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2]
            size = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            for k in range(3):
                normals[cell, t, k] = n[k] / max(size, TINY)
    return normals


@kernel()
def largest_dents_mm(corners, normals, triangles, planes, tips):  # type: ignore[no-untyped-def]
    """Largest height of a triangle's tip over the plane of the one beside it in each cell, shape (cells,) [mm].

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        normals: See `outward_normals`.
        triangles: Vertices of its triangles, shape (triangles, 3).
        planes: For each edge a triangle, shape (edges,).
        tips: And the vertex of the other one that is not on the edge, of the same shape.
    """
    dents = np.empty(len(corners))
    for cell in range(len(corners)):
        deepest = -np.inf
        for e in range(len(planes)):
            foot = triangles[planes[e], 0]
            height = np.float32(0)
            for k in range(3):
                height += normals[cell, planes[e], k] * np.float32(corners[cell, tips[e], k] - corners[cell, foot, k])
            deepest = max(deepest, float(height))
        dents[cell] = deepest
    return dents


@kernel()
def _planes(points, triangles, normals, heights):  # type: ignore[no-untyped-def]
    """Normals of any length and heights of the planes of one cell's faces, in place; of (6, triangles)."""
    u, v = np.empty(3), np.empty(3)
    for face in range(6):
        for t in range(len(triangles)):
            a, b, c = triangles[t]
            for k in range(3):
                u[k] = points[face, b, k] - points[face, a, k]
                v[k] = points[face, c, k] - points[face, a, k]
            for k in range(3):
                normals[face, t, k] = u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2]
            heights[face, t] = _dot(normals[face, t], points[face, a])


@kernel()
def _dot(one, other):  # type: ignore[no-untyped-def]
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@kernel()
def _margins(points, axes, inward, normals, heights, margins):  # type: ignore[no-untyped-def]
    """Margins of one cell, see `dented_cells`, in place; its faces are measured from its centre."""
    reach = 0.0
    for face in range(6):
        for point in range(points.shape[1]):
            for row in range(3):
                reach = max(reach, abs(_dot(points[face, point], inward[row])))
    for axis in range(3):
        margins[axis] = -np.inf
        for side in range(2):
            face = 2 * axis + side
            for t in range(normals.shape[1]):
                # Transformed as planes are, so that a place x in the frame is behind one where slopes @ x < height.
                along = _dot(normals[face, t], axes[axis]) * (2 * side - 1)
                beside = 0.0
                for other in range(3):
                    if other != axis:
                        beside += abs(_dot(normals[face, t], axes[other])) * reach
                margin = NEVER if along <= 0 else 1 - (heights[face, t] - beside) / along
                margins[axis] = max(margins[axis], margin)
    if margins[0] >= 1 or margins[1] >= 1 or margins[2] >= 1:
        margins[:] = NEVER


@kernel()
def _is_in_front(normals, heights, points, centre):  # type: ignore[no-untyped-def]
    """Whether all points of a face lie outside all planes of another one, so that no ray from that to it meets them.

    The planes are measured from a centre.
    """
    place = np.empty(3)
    for point in range(len(points)):
        for k in range(3):
            place[k] = points[point, k] - centre[k]
        for t in range(len(heights)):
            if _dot(normals[t], place) <= heights[t]:
                return False
    return True


@kernel()
def dented_cells(faces, triangles, dented, centres, axes, inward, neighbours):  # type: ignore[no-untyped-def]
    """What rays in and beside cells have to know of their dents.

    Args:
        faces: Vertices of each face of each cell, shape (cells, 6, vertices of a face, 3) [mm].
        triangles: Corners of the triangles of a face, shape (triangles of a face, 3).
        dented: Which cells have dents, shape (cells,).
        centres: Shape (cells, 3) [mm].
        axes: Axes of each cell's frame as rows, shape (cells, 3, 3) [mm].
        inward: Matrix into the frame, of the same shape.
        neighbours: Cell across each face, -1 where there is none, shape (cells, 6).

    Returns:
        Margins, the distance from the faces of each axis, in the cell's frame, beyond which a place is behind all
        planes of them, shape (cells, 3), in units of half a cell: -inf without dents, `NEVER` in all of a cell where
        one of them leaves no room; and whether the face across lies in front of each face, shape (cells, 6), true
        without dents.
    """
    cells, points = len(faces), faces.shape[2]
    margins, free = np.full((cells, 3), -np.inf), np.ones((cells, 6), np.bool_)
    normals, heights = np.empty((6, len(triangles), 3)), np.empty((6, len(triangles)))
    around = np.empty((6, points, 3))
    for cell in range(cells):
        if not dented[cell]:
            continue
        for face in range(6):
            for point in range(points):
                for k in range(3):
                    around[face, point, k] = faces[cell, face, point, k] - centres[cell, k]
        _planes(around, triangles, normals, heights)
        _margins(around, axes[cell], inward[cell], normals, heights, margins[cell])
        for face in range(6):
            across = neighbours[cell, face]
            if across >= 0:
                free[cell, face] = _is_in_front(normals[face], heights[face], faces[across, face ^ 1], centres[cell])
    return margins, free
