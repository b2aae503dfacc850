"""Walls that the renderer can still tell apart: thinner ones would let light through and must not become an image."""

import numpy as np

from magicsim.arrays import Array
from magicsim.errors import RenderError
from magicsim.geometry.grid import CellGrid
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.printed_cells import facing_vertices

SAFE_GAP_MM = 0.01
"""Least thickness of a wall [mm]: rays leave surfaces by 0.15 micrometres (`volpath`: 1.5), and flat walls of 0.5 keep
a white furnace within 0.1 %; the rest is a margin for bent ones."""


def check_walls(infill: Array, rest: SurfaceMesh, grid: CellGrid) -> None:
    """Refuses a deformed grid with a wall below the safe gap.

    Args:
        infill: Deformed infill vertices, shape (vertices, 3) [mm].
        rest: The infill at rest.
        grid: Its cells.

    Raises:
        RenderError: With the thinnest wall and its place.
    """
    thickness, place = thinnest_wall(infill, rest, grid)
    if thickness < SAFE_GAP_MM:
        raise RenderError(_message("wall", thickness, place, "wall_mm"))


def check_skin(infill: Array, indenter: Indenter, clearance_mm: float) -> None:
    """Refuses cells that the object reaches through the skin.

    Args:
        infill: Deformed infill vertices, shape (vertices, 3) [mm].
        indenter: The object where it is.
        clearance_mm: Distance of the skin from the object where they touch [mm].

    Raises:
        RenderError: With the thinnest skin and its place.
    """
    skin = indenter.distance(infill)[0] - max(clearance_mm, 0.0)
    thinnest = int(skin.argmin())
    if skin[thinnest] < SAFE_GAP_MM:
        raise RenderError(_message("skin", float(skin[thinnest]), infill[thinnest], "skin_mm"))


def _message(part: str, thickness: float, place: Array, field: str) -> str:
    x, y, z = place.round(2).tolist()
    return (
        f"the {part} near ({x:g}, {y:g}, {z:g}) mm is squeezed to {1e3 * thickness:.1f} micrometres: must stay above "
        f"{1e3 * SAFE_GAP_MM:g}, or light leaks through; press less or print {field} thicker"
    )


def thinnest_wall(infill: Array, rest: SurfaceMesh, grid: CellGrid) -> tuple[float, Array]:
    """Thickness of the thinnest wall between neighbouring cells [mm], and its middle, shape (3,) [mm].

    Facing vertices of two neighbours differ by the wall; its thickness is their distance along the wall's normal, the
    mean normal of the two faces. Negative where cells overlap.

    Args:
        infill: Deformed infill vertices, shape (vertices, 3) [mm].
        rest: The infill at rest.
        grid: Its cells.

    Returns:
        Infinity where no cell has a neighbour.
    """
    nx, ny, nz = grid.counts
    cell = rest.vertices.reshape(grid.cell_count, -1, 3)[0]
    moved = infill.reshape(nz, ny, nx, -1, 3)
    least, where = np.inf, np.zeros(3)
    for axis in range(3):
        if grid.counts[axis] == 1:
            continue
        high, low = facing_vertices(cell, axis)
        ahead = np.moveaxis(moved, 2 - axis, 0)
        near, far = ahead[:-1][..., high, :], ahead[1:][..., low, :]
        across = (far - near).reshape(-1, len(high), 3)
        normal = _normals(near, cell[high], axis) + _normals(far, cell[low], axis)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        thickness = np.einsum("wvi,wi->wv", across, normal.reshape(-1, 3))
        wall, vertex = np.unravel_index(thickness.argmin(), thickness.shape)
        if thickness[wall, vertex] < least:
            least = float(thickness[wall, vertex])
            where = ((near + far) / 2).reshape(-1, len(high), 3)[wall, vertex]
    return least, where


def _normals(faces: Array, rest: Array, axis: int) -> Array:
    """Mean normals of deformed faces along the positive axis, shape (..., 3), from their extreme corners' diagonals."""
    across = np.delete(rest, axis, axis=1)
    sums, differences = across.sum(1), across[:, 0] - across[:, 1]
    one = faces[..., sums.argmax(), :] - faces[..., sums.argmin(), :]
    other = faces[..., differences.argmax(), :] - faces[..., differences.argmin(), :]
    normal = np.cross(other, one)
    sign = (1, -1, 1)[axis]
    return np.asarray(sign * normal / np.linalg.norm(normal, axis=-1, keepdims=True))
