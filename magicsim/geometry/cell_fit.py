"""How whole cells fit into a core, and which values near those asked for would fit where they do not."""

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.design import CELL_MM, HEIGHT_MM, ElastomerDesign
from magicsim.geometry.flaws.unevenness import MIN_WALL_MM

ROUNDING = 1e-9
"""Slack of what is compared with a round number: 0.85 of 1 mm is 15 % off, and allowed."""
MAX_CELL_DEVIATION = 0.15 + ROUNDING
"""Largest relative difference between the resolved cell and the one asked for."""
STEP_MM = 0.01
"""Step of the values that are proposed [mm]."""


def fitted(core_mm: Array, cell_mm: Array | float, wall_mm: Array | float) -> tuple[Array, Array]:
    """Cells along a core and the edge that they get: n = max(1, round(core / (cell + wall))), cell = core / n - wall.

    Args:
        core_mm: Length of the core [mm].
        cell_mm: Edge asked for [mm].
        wall_mm: Between neighbouring cells [mm].

    Returns:
        Numbers of cells, and their edges [mm], of the arguments' common shape.
    """
    counts = np.maximum(1, np.round(core_mm / (cell_mm + wall_mm)))
    return counts, core_mm / counts - wall_mm


def values_that_fit(design: ElastomerDesign) -> dict[str, float]:
    """For each of `cell_mm`, `core_mm` and `wall_mm` the value nearest to the design's with which whole cells fit.

    The others stay as they are; a field of which no value helps is left out.

    Args:
        design: A block whose grid does not fit.
    """
    low, high = (limit - 2 * design.skin_mm for limit in HEIGHT_MM)
    ranges = {"cell_mm": CELL_MM, "core_mm": (max(low, STEP_MM), high), "wall_mm": (MIN_WALL_MM, CELL_MM[1])}
    found = {name: _nearest(design, name, *limits) for name, limits in ranges.items()}
    return {name: value for name, value in found.items() if value is not None}


def proposal(design: ElastomerDesign) -> str:
    """What to write instead, as the end of a message; empty where a change of one value does not help."""
    values = values_that_fit(design)
    return f"; what fits: {' or '.join(f'{name} = {value:g}' for name, value in values.items())}" if values else ""


def _nearest(design: ElastomerDesign, name: str, low: float, high: float) -> float | None:
    asked = float(getattr(design, name))
    values = np.round(np.arange(np.ceil(low / STEP_MM - ROUNDING), high / STEP_MM + ROUNDING) * STEP_MM, 6)
    given = {key: np.full(len(values), float(getattr(design, key))) for key in ("cell_mm", "core_mm", "wall_mm")}
    given[name] = values
    outer = np.array(design.footprint_mm)[:, None] - 2 * design.skin_mm
    cores = np.concatenate([np.broadcast_to(outer, (2, len(values))), given["core_mm"][None]])
    _, cells = fitted(cores, given["cell_mm"], given["wall_mm"])
    deviation = np.abs(cells / given["cell_mm"] - 1).max(0)
    fits = values[(deviation <= MAX_CELL_DEVIATION) & (cores > 0).all(0)]
    return float(fits[np.abs(fits - asked).argmin()]) if len(fits) else None
