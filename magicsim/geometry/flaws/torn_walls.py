"""Walls that a print lacks, as light meets them: two cells become one.

The mesh keeps its vertices and the number of its triangles. The cell above a missing wall hangs on the facing vertices
of the cell below, whose own face there stays as a membrane that light does not feel: it tells in which of the two cells
a ray is.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Index
from magicsim.geometry.grid import CellGrid
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.rounded_cell import facing_vertices

STREAM = 0x7047
"""Keeps a print's random numbers apart from others of that seed."""
WHOLE = 2**32 - 1
"""Stands for no cell behind a triangle."""
Faces = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True, kw_only=True)
class FusedCells:
    """How the cells hang together where walls are missing."""

    pairs: Index
    """Cells below and above each missing wall, shape (walls, 2); no cell is there twice."""
    faces: Faces
    """Triangles of all cells, shape (triangles, 3), collapsed to a point where a membrane belongs to the cell below."""
    closed: Faces
    """Those of closed cells, which share a membrane."""
    without_membranes: Faces
    """Those of the fused cells, collapsed to points where a wall is missing."""
    beyond: npt.NDArray[np.uint32]
    """Cell above the membrane that a triangle is, or `WHOLE`, shape (triangles,)."""


def draw_fused_cells(share: float, seed: int, grid: CellGrid, cells: SurfaceMesh) -> FusedCells | None:
    """Takes walls out of a grid; None where none is missing.

    Args:
        share: Of all walls between two cells.
        seed: Of the print.
        grid: The cells.
        cells: Their mesh as drawn, cell after cell.
    """
    below, axes = _torn(share, seed, grid)
    if not len(below):
        return None
    above = below + np.cumprod([1, *grid.counts[:2]])[axes]
    count = len(cells.vertices) // grid.cell_count
    one = cells.faces[: len(cells.faces) // grid.cell_count]
    opposite = [facing_vertices(cells.vertices[:count], axis) for axis in range(3)]
    closed = cells.faces.reshape(grid.cell_count, -1, 3).copy()
    beyond = np.full(closed.shape[:2], WHOLE, np.uint32)
    faces, bare = closed.copy(), closed.copy()
    for axis, (high, low) in enumerate(opposite):
        ours = axes == axis
        under, over = below[ours], above[ours]
        hung = np.arange(count) + over[:, None] * count
        hung[:, low] = high + under[:, None] * count
        closed[over] = faces[over] = bare[over] = hung[:, one]
        lower, upper = (np.flatnonzero(np.isin(one, side).all(1)) for side in (high, low))
        beyond[under[:, None], lower] = over[:, None]
        for found in (faces, bare):
            found[over[:, None], upper] = found[over[:, None], upper][..., :1]
        bare[under[:, None], lower] = bare[under[:, None], lower][..., :1]
    return FusedCells(
        pairs=np.stack([below, above], 1),
        faces=faces.reshape(-1, 3),
        closed=closed.reshape(-1, 3),
        without_membranes=bare.reshape(-1, 3),
        beyond=beyond.ravel(),
    )


def _torn(share: float, seed: int, grid: CellGrid) -> tuple[Index, Index]:
    """Cells below missing walls and the axes across these, walls in random order, of each cell one at the most."""
    if share == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    steps = np.cumprod([1, *grid.counts[:2]])
    places = np.stack(np.unravel_index(np.arange(grid.cell_count), grid.counts[::-1]), 1)[:, ::-1]
    cell, axis = np.nonzero(places < np.array(grid.counts) - 1)
    random = np.random.default_rng(np.random.SeedSequence([seed, STREAM]))
    used, wanted = np.zeros(grid.cell_count, bool), round(share * len(cell))
    found: list[int] = []
    for wall in random.permutation(len(cell)).tolist():
        if len(found) == wanted:
            break
        ends = [cell[wall], cell[wall] + steps[axis[wall]]]
        if not used[ends].any():
            used[ends] = True
            found.append(wall)
    order = np.sort(np.array(found, np.int64))
    return cell[order], axis[order]
