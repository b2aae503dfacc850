"""How trustworthy the deformations of an episode are, as rows of a page's table."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from magicsim.report.text import number, quantity, scientific
from magicsim.simulation.episode import FrameTruth, SimulatedFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveRow:
    """The worst value of one figure."""

    name: str
    value: str
    index: int
    """Place in the stream of the frame that has it."""


def solve_rows(frames: Sequence[SimulatedFrame]) -> list[SolveRow]:
    """Worst figures over the frames with contact or with a solve; none where there was neither.

    Args:
        frames: Frames of the stream, in order.
    """
    solved = [frame for frame in frames if frame.truth.contact or frame.truth.solve.iterations]
    figures: dict[str, tuple[Callable[[FrameTruth], float], Callable[[float], str]]] = {
        "most iterations of a frame": (lambda one: one.solve.iterations, lambda value: number(value, 0)),
        "smallest Jacobian": (lambda one: -one.solve.min_jacobian, lambda value: number(-value, 3)),
        "deepest penetration": (lambda one: one.solve.max_penetration_mm, lambda value: f"{scientific(value)}\u00a0mm"),
        "worst force balance": (lambda one: one.solve.force_balance, scientific),
        "largest force": (lambda one: math.hypot(*one.force_n), lambda value: quantity(value, "N")),
        "largest contact area": (lambda one: one.contact_area_mm2, lambda value: quantity(value, "mm\u00b2", 1)),
    }
    rows = []
    for name, (measure, write) in figures.items() if solved else ():
        worst = max((frame.truth for frame in solved), key=lambda truth: _badness(measure(truth)))
        rows.append(SolveRow(name=name, value=write(measure(worst)), index=worst.index))
    return rows


def _badness(value: float) -> float:
    """The value; one that is not a number is the worst."""
    return math.inf if math.isnan(value) else value
