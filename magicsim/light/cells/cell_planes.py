"""Planes of the triangles of deformed cells: numba kernels over all of them, each cell for itself.

The dents that a cell's faces have, how far from them a ray must end so that it has met none, and whether another face
lies in front of all planes of one. Only cells with dents are asked for more than that.
"""

# ruff: noqa: ANN001, ANN201, ANN202 -- numba infers the types of the kernels.

import numpy as np

from magicsim.kernels import kernel

NEVER = 2.0
"""Margin of cells in which no place is in front of all planes of their faces."""
TINY = np.float32(1e-30)


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
    """Normals of any length and heights of the planes of one cell's faces, in place.

    Args:
        points: Vertices of each face, shape (6, vertices of a face, 3) [mm].
        triangles: Corners of the triangles of a face, shape (triangles of a face, 3).
        normals: Shape (6, triangles of a face, 3).
        heights: Shape (6, triangles of a face).
    """
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
    """Margins of one cell, see `dented_cells`, in place.

    Args:
        points: Vertices of each face from the cell's centre, shape (6, vertices of a face, 3) [mm].
        axes: Axes of the cell's frame as rows, shape (3, 3) [mm].
        inward: Matrix into the frame, shape (3, 3).
        normals: See `_planes`.
        heights: See there.
        margins: Shape (3,).
    """
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
    """Whether all of a face lies outside all planes of another one, so that no ray from that to it meets them.

    Args:
        normals: Of the other face's triangles, shape (triangles of a face, 3).
        heights: Of their planes, shape (triangles of a face,).
        points: Vertices of the face, shape (vertices of a face, 3) [mm].
        centre: What the planes are measured from, shape (3,) [mm].
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
