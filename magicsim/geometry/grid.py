"""Whole cells: how many fit in the core, and where their planes lie."""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np

from magicsim.arrays import Array
from magicsim.errors import GeometryError
from magicsim.geometry.design import CELL_MM, HEIGHT_MM, ElastomerDesign
from magicsim.geometry.flaws import MIN_WALL_MM

Place = Literal["cell", "wall"]
"""The centre of a cell, or where walls cross."""
MAX_CELLS = 200_000
"""More cells than this would not fit in memory as meshes."""
Planes = tuple[Array, Array, Array]
"""Increasing node planes along x, y and z [mm]."""
ROUNDING = 1e-9
"""Slack of what is compared with a round number: 0.85 of 1 mm is 15 % off, and allowed."""
MAX_CELL_DEVIATION = 0.15 + ROUNDING
"""Largest relative difference between the resolved cell and the one asked for."""
SPACING_SLACK = 0.05
"""Part of a spacing that an interval may be longer than a whole number of them."""
STEP_MM = 0.01
"""Step of the values that are proposed [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellGrid:
    """The resolved grid: a whole number of cells on each axis, the skin exact."""

    counts: tuple[int, int, int]
    """Cells along x, y and z."""
    pitch_mm: Array
    """Distance between grid planes, shape (3,) [mm]."""
    cell_mm: Array
    """Edges of one infill cuboid, pitch - wall, shape (3,) [mm]."""
    origin_mm: Array
    """Corner of the core at smallest x, y, z, shape (3,) [mm]."""

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return int(np.prod(self.counts))

    @property
    def infill_volume_mm3(self) -> float:
        """Volume of all infill cuboids [mm3], the closed form."""
        return float(self.cell_count * np.prod(self.cell_mm))

    def planes_mm(self, axis: int) -> Array:
        """Grid planes along one axis, shape (counts[axis] + 1,) [mm]."""
        return np.asarray(self.origin_mm[axis] + self.pitch_mm[axis] * np.arange(self.counts[axis] + 1))

    def centres_mm(self) -> Array:
        """Cell centres in x-fastest order, shape (cells, 3) [mm]."""
        axes = [self.planes_mm(axis)[:-1] + self.pitch_mm[axis] / 2 for axis in range(3)]
        z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
        return np.stack([x, y, z], -1).reshape(-1, 3)


@lru_cache(maxsize=64)
def resolve_grid(design: ElastomerDesign) -> CellGrid | None:
    """Fits whole cells into the core: n = max(1, round(core / (cell + wall))), pitch = core / n, cell = pitch - wall.

    Worked out once for each design, None for one without a grid; the arrays of the result cannot be written.

    Raises:
        GeometryError: The footprint leaves no core, a resolved cell differs by more than 15 % from the one asked
            for, or there are too many cells.
    """
    if not design.has_grid:
        return None
    sizes = np.array([*design.footprint_mm, design.height_mm])
    core = sizes - 2 * design.skin_mm
    asked = design.cell_mm + design.wall_mm
    for axis, name in enumerate("xyz"):
        if core[axis] < asked * (1 - MAX_CELL_DEVIATION):
            raise GeometryError(
                f"no cell fits along {name}: the core is {core[axis]:.4g} mm (size {sizes[axis]:g} - 2 x skin "
                f"{design.skin_mm:g}), one cell and its wall need cell_mm + wall_mm = {asked:g} mm{_proposal(design)}"
            )
    counts, cell = _fitted(core, design.cell_mm, design.wall_mm)
    counts, pitch = counts.astype(int), core / counts
    deviation = cell / design.cell_mm - 1
    worst = int(np.argmax(np.abs(deviation)))
    if abs(deviation[worst]) > MAX_CELL_DEVIATION:
        raise GeometryError(
            f"cell_mm = {design.cell_mm:g} resolves to {cell[worst]:.4g} mm along {'xyz'[worst]} "
            f"({deviation[worst]:+.0%}): at most {MAX_CELL_DEVIATION:.0%} is allowed"
            f"{_proposal(design) or '; change several of cell_mm, wall_mm and core_mm'}"
        )
    if np.prod(counts) > MAX_CELLS:
        msg = f"{np.prod(counts)} cells are too many: at most {MAX_CELLS}; use larger cells or a smaller core"
        raise GeometryError(msg)
    origin = np.array([-core[0] / 2, -core[1] / 2, design.skin_mm])
    for shared in (pitch, cell, origin):
        shared.setflags(write=False)
    return CellGrid(counts=tuple(int(n) for n in counts), pitch_mm=pitch, cell_mm=cell, origin_mm=origin)  # type: ignore[arg-type]


def _fitted(core_mm: Array, cell_mm: Array | float, wall_mm: Array | float) -> tuple[Array, Array]:
    """Numbers of cells along a core, and the edges that they get [mm], for a cell and a wall that are asked for."""
    counts = np.maximum(1, np.round(core_mm / (cell_mm + wall_mm)))
    return counts, core_mm / counts - wall_mm


def _proposal(design: ElastomerDesign) -> str:
    """Values with which whole cells would fit, as the end of a message; empty where a change of one value is no help.

    For each of `cell_mm`, `core_mm` and `wall_mm` it is the one nearest to the design's, the others as they are.
    """
    low, high = (limit - 2 * design.skin_mm for limit in HEIGHT_MM)
    ranges = {"cell_mm": CELL_MM, "core_mm": (max(low, STEP_MM), high), "wall_mm": (MIN_WALL_MM, CELL_MM[1])}
    nearest = {name: _nearest(design, name, *limits) for name, limits in ranges.items()}
    values = [f"{name} = {value:g}" for name, value in nearest.items() if value is not None]
    return f"; what fits: {' or '.join(values)}" if values else ""


def _nearest(design: ElastomerDesign, name: str, low: float, high: float) -> float | None:
    asked = float(getattr(design, name))
    values = np.round(np.arange(np.ceil(low / STEP_MM - ROUNDING), high / STEP_MM + ROUNDING) * STEP_MM, 6)
    given = {key: np.full(len(values), float(getattr(design, key))) for key in ("cell_mm", "core_mm", "wall_mm")}
    given[name] = values
    outer = np.array(design.footprint_mm)[:, None] - 2 * design.skin_mm
    cores = np.concatenate([np.broadcast_to(outer, (2, len(values))), given["core_mm"][None]])
    _, cells = _fitted(cores, given["cell_mm"], given["wall_mm"])
    deviation = np.abs(cells / given["cell_mm"] - 1).max(0)
    fits = values[(deviation <= MAX_CELL_DEVIATION) & (cores > 0).all(0)]
    return float(fits[np.abs(fits - asked).argmin()]) if len(fits) else None


def symmetric_place(design: ElastomerDesign, place: Place) -> tuple[float, float]:
    """Point x, y of the contact face next to its middle about which the grid is symmetric, or the middle [mm]."""
    grid = resolve_grid(design)
    if grid is None:
        return 0.0, 0.0
    beside = 0.5 if place == "cell" else 0.0
    x, y = (float(grid.planes_mm(axis)[grid.counts[axis] // 2] + beside * grid.pitch_mm[axis]) for axis in (0, 1))
    return x, y


def node_spacing_mm(design: ElastomerDesign) -> float:
    """Largest node spacing of `lattice_planes`: `lattice.spacing_mm`, or the grid's pitch, or 1 without a grid [mm]."""
    grid = resolve_grid(design)
    return design.lattice.spacing_mm or (float(grid.pitch_mm.max()) if grid is not None else 1.0)


def lattice_planes(design: ElastomerDesign, grid: CellGrid | None) -> Planes:
    """Node planes of the deformation lattice along x, y and z: the grid planes and outer faces, refined.

    Each interval is split evenly so that no spacing exceeds `lattice.spacing_mm` by more than 5 % (the pitch of whole
    cells seldom is the round figure that was asked for).
    """
    half_x, half_y = design.footprint_mm[0] / 2, design.footprint_mm[1] / 2
    outer = ((-half_x, half_x), (-half_y, half_y), (0.0, design.height_mm))
    planes = []
    for axis, (low, high) in enumerate(outer):
        inner, pitch = (grid.planes_mm(axis), float(grid.pitch_mm[axis])) if grid is not None else (np.empty(0), 1.0)
        coarse = np.array([low, *inner, high])
        spacing = design.lattice.spacing_mm or pitch
        parts = [np.linspace(a, b, split_count(b - a, spacing), endpoint=False) for a, b in pairwise(coarse)]
        planes.append(np.concatenate([*parts, coarse[-1:]]))
    x, y, z = planes
    return x, y, z


def split_count(length_mm: float, spacing_mm: float) -> int:
    """Lattice cells along an interval: the fewest that keep to the spacing and its slack."""
    return max(1, math.ceil(length_mm / spacing_mm - SPACING_SLACK))
