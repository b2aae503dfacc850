"""Bubbles and flakes of one print: where they are, and where the deformed cells carry them.

Each lies in one cell, at a place in units of it, and clear of its walls and of the others. It moves with the corners of
its cell; its radius shrinks where the cell is squeezed, by the largest compression there, so that it stays inside, and
does not grow.
"""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index, Mask
from magicsim.geometry.flaws import Inclusions
from magicsim.geometry.grid import CellGrid

STREAM = 0xB0BB
"""Keeps a print's random numbers apart from others of that seed."""
APART = 1.02
"""Least distance of two centres in units of the sum of their radii, and of one from a wall in units of its own."""
TRIES = 50
"""Places that are tried for each; one for which a cell has no more room is left out."""


_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedInclusions:
    """Inclusions in one state of the cells, cell after cell."""

    cell: Index
    """Number of each one's cell, shape (inclusions,)."""
    centres_mm: Array
    """Shape (inclusions, 3), in the sensor's frame [mm]."""
    radii_mm: Array
    """Shape (inclusions,) [mm]."""
    normals: Array
    """Normals of flakes, unit vectors, shape (inclusions, 3); of no meaning for bubbles."""
    is_bubble: Mask

    def air_mm3(self, cells: int) -> Array:
        """Volume of the bubbles in each cell, shape (cells,) [mm3]."""
        volumes = np.where(self.is_bubble, 4 / 3 * np.pi * self.radii_mm**3, 0.0)
        return np.asarray(np.bincount(self.cell, volumes, cells), np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnInclusions:
    """Inclusions of one print."""

    cell: Index
    """Number of each one's cell, in order, shape (inclusions,)."""
    places: Array
    """From -1 to 1 along each edge of the cell, shape (inclusions, 3)."""
    radii_mm: Array
    normals: Array
    """Normals of flakes at rest, shape (inclusions, 3)."""
    is_bubble: Mask
    half_mm: Array
    """Half of a cell's edges as drawn, shape (3,) [mm]."""
    corners: Index
    """Vertices at the corners of a cell, x fastest, shape (8,)."""
    cells: int

    def placed(self, vertices: Array) -> PlacedInclusions:
        """The inclusions in cells with these vertices, cell after cell, shape (vertices, 3) [mm]."""
        cells = vertices.reshape(self.cells, -1, 3)[self.cell][:, self.corners]
        weights, slopes = _trilinear(self.places)
        centres = np.einsum("ic,icd->id", weights, cells)
        # Columns are where the edges of the drawn cell go, per mm of them.
        gradient = np.einsum("ica,icd->ida", slopes, cells) / self.half_mm
        shrunk = np.minimum(np.linalg.svd(gradient, compute_uv=False)[:, -1], 1)
        turned = np.einsum("iad,ia->id", np.linalg.inv(gradient), self.normals)
        return PlacedInclusions(
            cell=self.cell, centres_mm=centres, radii_mm=self.radii_mm * shrunk, is_bubble=self.is_bubble,
            normals=turned / np.linalg.norm(turned, axis=1, keepdims=True),
        )  # fmt: skip


def draw_inclusions(inclusions: Inclusions, grid: CellGrid, cell_vertices: Array) -> DrawnInclusions | None:
    """The bubbles and flakes of a print, None where there are none.

    `cell_vertices` are those of the first cell as drawn, shape (vertices of a cell, 3) [mm].
    """
    if inclusions.is_clean:
        return None
    random = np.random.default_rng(np.random.SeedSequence([inclusions.seed, STREAM]))
    lowest = cell_vertices.min(0)
    ends = lowest + (cell_vertices.max(0) - lowest) * _CORNERS
    corners = np.linalg.norm(cell_vertices - ends[:, None], axis=2).argmin(1)
    # Corners of rounded cells lie further in.
    half = np.ptp(cell_vertices[corners], axis=0) / 2
    volume = grid.infill_volume_mm3
    kinds = ((True, inclusions.bubbles_per_mm3, inclusions.bubble_radius_mm),
             (False, inclusions.flakes_per_mm3, inclusions.flake_radius_mm))  # fmt: skip
    radii, bubbles = [], []
    for filled, density, (low, high) in kinds:
        radii.append(random.uniform(low, high, random.poisson(density * volume)))
        bubbles.append(np.full(len(radii[-1]), filled))
    radius, is_bubble = np.concatenate(radii), np.concatenate(bubbles)
    cell, directions = random.integers(grid.cell_count, size=len(radius)), random.standard_normal((len(radius), 3))
    tried = random.uniform(-1, 1, (len(radius), TRIES, 3))
    places, kept = _apart(cell, radius, tried, half)
    if not kept.any():
        return None
    order = np.flatnonzero(kept)[np.argsort(cell[kept], kind="stable")]
    normals = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return DrawnInclusions(
        cell=cell[order], places=places[order], radii_mm=radius[order], normals=normals[order],
        is_bubble=is_bubble[order], half_mm=half, corners=corners, cells=grid.cell_count,
    )  # fmt: skip


def _apart(cell: Index, radius: Array, tried: Array, half: Array) -> tuple[Array, Mask]:
    """Places in units of the cell that keep clear of walls and of each other, and which found one; the widest first."""
    places, kept = np.zeros((len(radius), 3)), np.zeros(len(radius), bool)
    inside: dict[int, list[int]] = {}
    for each in np.argsort(-radius, kind="stable").tolist():
        others = inside.setdefault(int(cell[each]), [])
        for place in tried[each] * (1 - APART * radius[each] / half):
            away = np.linalg.norm((places[others] - place) * half, axis=1)
            if (away > APART * (radius[others] + radius[each])).all():
                places[each], kept[each] = place, True
                others.append(each)
                break
    return places, kept


def _trilinear(places: Array) -> tuple[Array, Array]:
    """Weights of a cell's corners, shape (places, 8), and their slopes along the edges, shape (places, 8, 3)."""
    signs = 2 * _CORNERS - 1
    along = (1 + places[:, None] * signs) / 2
    slopes = np.stack([signs[:, axis] / 2 * np.delete(along, axis, axis=2).prod(2) for axis in range(3)], axis=2)
    return along.prod(2), slopes
