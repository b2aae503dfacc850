"""How trustworthy the deformations of an episode are, as rows of a page's table."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from magicsim.report.text import number, quantity, scientific
from magicsim.simulation.episode import SimulatedFrame


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
    figures: tuple[tuple[str, Callable[[SimulatedFrame], float], Callable[[float], str]], ...] = (
        (
            "most iterations of a frame",
            lambda one: one.truth.solve.iterations,
            lambda value: number(value, 0),
        ),
        ("smallest Jacobian", lambda one: -one.truth.solve.min_jacobian, lambda value: number(-value, 3)),
        (
            "deepest penetration",
            lambda one: one.truth.solve.max_penetration_mm,
            lambda value: f"{scientific(value)}\u00a0mm",
        ),
        ("worst force balance", lambda one: one.truth.solve.force_balance, scientific),
        ("largest force", lambda one: math.hypot(*one.truth.force_n), lambda value: quantity(value, "N")),
        (
            "largest contact area",
            lambda one: one.truth.contact_area_mm2,
            lambda value: quantity(value, "mm\u00b2", 1),
        ),
    )
    return [row for figure in figures for row in _worst(solved, *figure)]


def _worst(
    frames: Sequence[SimulatedFrame],
    name: str,
    measure: Callable[[SimulatedFrame], float],
    write: Callable[[float], str],
) -> list[SolveRow]:
    """The row of the largest measure, a value that is not a number counting as the largest."""
    if not frames:
        return []
    value, frame = max(((measure(one), one) for one in frames), key=lambda pair: _badness(pair[0]))
    return [SolveRow(name=name, value=write(value), index=frame.truth.index)]


def _badness(value: float) -> float:
    return math.inf if math.isnan(value) else value
