"""How much faster one method is than another where both have the same error."""

from collections.abc import Iterable
from dataclasses import dataclass

from magicsim.bench.deform.methods import FELUPE, GRADED, QUARTER
from magicsim.bench.deform.rows import SOLVED, BenchRow


@dataclass(frozen=True, slots=True, kw_only=True)
class EqualError:
    """One result of another method, and the cheapest of the graded lattice that is as accurate."""

    depth_mm: float
    other: str
    """Method and setting."""
    other_error: float
    """Relative error of the force."""
    other_seconds: float
    """Seconds of its warm step."""
    setting: str | None
    """Spacing and tolerance of the lattice; None where none was as accurate."""
    seconds: float | None
    ratio: float | None
    """Seconds of the other over the lattice's."""


def equal_errors(rows: Iterable[BenchRow]) -> list[EqualError]:
    """For every solved result of felupe, the fastest graded lattice whose force is at least as accurate there.

    A quarter by symmetry is compared with a quarter, and a whole block with a whole one.

    An error that happens to vanish at one depth is no accuracy: a lattice counts with its largest error over all depths
    up to that one.
    """
    solved = [row for row in rows if row.outcome == SOLVED]
    lattices = [row for row in solved if row.method.startswith(GRADED)]
    found = []
    for other in (row for row in solved if row.method.startswith(FELUPE)):
        error = _largest_error(solved, other)
        able = [
            row for row in lattices
            if row.depth_mm == other.depth_mm and (QUARTER in row.method) == (QUARTER in other.method)
            and _largest_error(solved, row) <= error
        ]  # fmt: skip
        best = min(able, key=_seconds, default=None)
        found.append(
            EqualError(
                depth_mm=other.depth_mm,
                other=f"{other.method}, {other.setting}",
                other_error=error,
                other_seconds=_seconds(other),
                setting=f"{best.method}, {best.setting}" if best is not None else None,
                seconds=_seconds(best) if best is not None else None,
                ratio=_seconds(other) / _seconds(best) if best is not None else None,
            )
        )
    return found


def _largest_error(rows: Iterable[BenchRow], row: BenchRow) -> float:
    """Largest error of one method and setting at all depths up to a row's."""
    return max(
        each.error
        for each in rows
        if (each.method, each.setting) == (row.method, row.setting)
        and each.depth_mm <= row.depth_mm
        and each.error is not None
    )


def _seconds(row: BenchRow) -> float:
    return row.seconds if row.seconds is not None else float("inf")
