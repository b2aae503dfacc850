"""Which of the published printing limits a design keeps.

Sources: mini-MagicTac's recommended and printed sizes (Fan, Li, Zhang, arXiv 2505.24382). The thinnest wall is assumed:
nobody published one, and 0.1 to 0.2 mm are the plausible walls of the base design.
"""

from dataclasses import dataclass

from magicsim.sweep.measures import Measured
from magicsim.sweep.result import Block


@dataclass(frozen=True, slots=True, kw_only=True)
class PrintLimit:
    """A range that prints are known to come out in."""

    name: str
    low: float
    high: float


LIMITS = {
    "skin_mm": (
        PrintLimit(name="printed skin", low=0.3, high=3.0), PrintLimit(name="recommended skin", low=0.5, high=1.0),
    ),
    "cell_mm": (PrintLimit(name="printed cell", low=0.6, high=1.0),),
    "height_mm": (PrintLimit(name="printed height", low=2.0, high=20.0),),
    "core_mm": (PrintLimit(name="recommended core", low=4.0, high=6.0),),
    "wall_mm": (PrintLimit(name="assumed thinnest wall", low=0.1, high=float("inf")),),
}  # fmt: skip
"""Limits of each size [mm]; the core is recommended as 'about 5 mm'."""
SLACK_MM = 1e-6


def printability(block: Block) -> Measured:
    """Share of the limits that a block keeps, with the names of those it does not."""
    kept, broken = 0, []
    for name, value in sizes_mm(block).items():
        for limit in LIMITS[name]:
            if limit.low - SLACK_MM <= value <= limit.high + SLACK_MM:
                kept += 1
            else:
                broken.append(f"{limit.name} {_range(limit)} mm, here {value:.3g}")
    share = kept / (kept + len(broken))
    return Measured(value=share, low=share, high=share, note="; ".join(broken))


def sizes_mm(block: Block) -> dict[str, float]:
    """The sizes that limits exist for [mm]; cells as resolved, the smallest edge of them."""
    core = block.height_mm - 2 * block.skin_mm
    sizes = {"skin_mm": block.skin_mm, "height_mm": block.height_mm, "core_mm": core}
    if block.cell_mm is not None:
        sizes |= {"cell_mm": round(min(block.cell_mm), 6), "wall_mm": block.wall_mm}
    return sizes


def _range(limit: PrintLimit) -> str:
    return f"at least {limit.low:g}" if limit.high == float("inf") else f"{limit.low:g} to {limit.high:g}"
