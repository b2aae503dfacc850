"""How the surface of one infill cell is put together: six faces, each a square of quads that are split in two.

All faces are brought into one canonical order, so that one piece of code meets any of them with a ray.
"""

from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np

from magicsim.arrays import Index
from magicsim.geometry.elastomer import Elastomer

FACES = 6
"""Faces of a cell; face 2 * axis + side, where side is 1 towards +axis."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellTopology:
    """Topology of every cell of a grid, because all are printed alike."""

    counts: tuple[int, int, int]
    """Cells along x, y and z."""
    parts: int
    """Quads along an edge of a face."""
    corners: Index
    """Vertex of the cell for each vertex of a face, row after row, shape (6, (parts + 1)^2)."""
    triangles: Index
    """Triangle of the cell for each canonical triangle of a face, shape (6, 2 * parts^2)."""

    @classmethod
    def of(cls, elastomer: Elastomer) -> Self | None:
        """Topology of an elastomer's cells, or None without a grid or where its cells are no boxes."""
        grid, infill = elastomer.grid, elastomer.infill
        # A ray beside a fillet may meet the cell diagonally across before the one that its face looks at.
        if grid is None or infill is None or elastomer.design.unevenness.crossing_radius_mm > 0:
            return None
        infill = elastomer.boxed_cells
        size = len(infill.vertices) // grid.cell_count
        faces = infill.faces[: elastomer.triangles_per_cell].astype(np.int64)
        low, high = infill.vertices[:size].min(0), infill.vertices[:size].max(0)
        parts = round((len(faces) / 12) ** 0.5)
        places = np.rint((infill.vertices[:size] - low) / (high - low) * parts).astype(int)
        found = [_canonical(places, faces, parts, axis, side) for axis, side in product(range(3), range(2))]
        whole = [face for face in found if face is not None]
        if len(whole) < FACES:
            return None
        corners, triangles = (np.stack(arrays) for arrays in zip(*whole, strict=True))
        return cls(counts=grid.counts, parts=parts, corners=corners, triangles=triangles)

    @property
    def face_of(self) -> Index:
        """Face of each triangle of a cell, shape (triangles of a cell,)."""
        result = np.empty(self.triangles.size, np.int64)
        result[self.triangles] = np.arange(FACES)[:, None]
        return result

    def neighbours(self) -> Index:
        """Cell across each face of each cell, -1 where there is none, shape (cells, 6)."""
        nx, ny, nz = self.counts
        index = np.full((nz + 2, ny + 2, nx + 2), -1)
        index[1:-1, 1:-1, 1:-1] = np.arange(nx * ny * nz).reshape(nz, ny, nx)
        across = [np.roll(index, -(2 * side - 1), 2 - axis) for axis, side in product(range(3), range(2))]
        return np.stack([array[1:-1, 1:-1, 1:-1].ravel() for array in across], 1)


def canonical_triangles(parts: int) -> Index:
    """Corners of the triangles of a face, counter-clockwise from outside, shape (2 * parts^2, 3)."""
    row = parts + 1
    found = []
    for i, j in product(range(parts), range(parts)):
        a, b, c, d = row * i + j, row * (i + 1) + j, row * (i + 1) + j + 1, row * i + j + 1
        found += [(a, b, c), (a, c, d)]
    return np.array(found)


def _canonical(places: Index, faces: Index, parts: int, axis: int, side: int) -> tuple[Index, Index] | None:
    """Corners and triangles of one face, or None if no turn of the square fits its triangles."""
    on_face = places[:, axis] == side * parts
    mine = np.flatnonzero(on_face[faces].all(1))
    wanted = canonical_triangles(parts)
    if len(mine) != len(wanted):
        return None
    known = {tuple(np.roll(faces[index], turn)): index for index in mine for turn in range(3)}
    others = [other for other in range(3) if other != axis]
    for (u, v), flip_u, flip_v in product((others, others[::-1]), (False, True), (False, True)):
        i = parts - places[:, u] if flip_u else places[:, u]
        j = parts - places[:, v] if flip_v else places[:, v]
        corners = np.empty((parts + 1) ** 2, np.int64)
        corners[((parts + 1) * i + j)[on_face]] = np.flatnonzero(on_face)
        matches = [known.get(tuple(corners[triangle])) for triangle in wanted]
        whole = [match for match in matches if match is not None]
        if len(whole) == len(wanted):
            return corners, np.array(whole)
    return None
