"""What a measure says of a sweep as a whole: whether it tells designs apart, whether one is best, and trends.

Two designs are told apart where their values differ by more than the interval of the difference, sqrt(a^2 + b^2) with
the parts a and b of their own intervals that face each other (Zou and Donner, Stat. Med. 27 (2008) 1693). Among n
designs some pair differs by chance: intervals are widened to the level 0.05 / m, m the number of pairs that are looked
at (Bonferroni), as if they were of Gaussian errors. A bound, whose interval is open, reaches to infinity
on that side.

Published trends: a thicker skin or a thinner core is harder (Fan, Li, Zhang, arXiv 2505.24382, and its predecessor
arXiv 2402.01366). That a thicker skin is less sensitive, to depth and to force, is our own reading. A trend is shown
where the mean change of all rows of designs that differ in one field alone is above its interval, that of a difference
of independent errors, sqrt(h1^2 + h2^2) with the half widths h, and no row says the opposite.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from statistics import NormalDist

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.judge.measures import TAIL
from magicsim.sweep.measures import MEASURES, Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import Objective

SKIN, CORE = "design.skin_mm", "design.core_mm"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trend:
    """A statement and the measure that it is about."""

    statement: str
    field: str
    measure: str
    rises: bool
    """Whether the measure rises with the field."""


TRENDS = (
    Trend(statement="thicker skin, harder", field=SKIN, measure="shore_a", rises=True),
    Trend(statement="thicker skin, stiffer", field=SKIN, measure="force_1mm_n", rises=True),
    *(
        Trend(statement=f"thicker skin, less sensitive to {to} (our reading)", field=SKIN, measure=measure, rises=False)
        for to, measure in (("depth", "sensitivity_per_mm"), ("force", "sensitivity_per_n"))
    ),
    Trend(statement="deeper core, softer", field=CORE, measure="shore_a", rises=False),
    Trend(statement="deeper core, less stiff", field=CORE, measure="force_1mm_n", rises=False),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendCheck(Trend):
    """How far a sweep bears a trend out."""

    series: int
    """Rows of designs that differ in the field alone."""
    steps: int
    """Neighbours in them."""
    steps_right: int
    """Neighbours that differ the right way."""
    ends_right: int
    """Rows whose last design differs from the first the right way."""
    ends_clear: int
    """Rows of `ends_right` whose ends differ by more than their intervals."""
    ends_contrary: int
    """Rows whose ends differ by more than that the wrong way."""
    change: float
    """From first to last design, mean over rows, in the measure's unit."""
    low: float | None
    """Lower end of its interval; None where a design of some row has none."""
    high: float | None
    """Upper end."""

    @property
    def holds(self) -> bool:
        """Whether the mean change is clear, the right way, and no row is clear the wrong way."""
        if self.low is None or self.high is None or self.ends_contrary:
            return False
        return self.low > 0 if self.rises else self.high < 0


def check_trends(results: Sequence[DesignResult]) -> list[TrendCheck]:
    """Every trend that some row of designs can show."""
    rows_of = ((trend, series(results, trend.field, trend.measure)) for trend in TRENDS)
    return [_check(trend, rows) for trend, rows in rows_of if rows]


def series(results: Sequence[DesignResult], field: str, measure: str) -> list[list[Measured]]:
    """A measure along a field, one row for each choice of all other fields, of two designs or more."""
    rows: dict[tuple[object, ...], dict[float | str, Measured]] = defaultdict(dict)
    for result in results:
        found = result.measures.get(measure)
        if found is None or found.value is None or field not in result.values:
            continue
        others = tuple(sorted((name, value) for name, value in result.values.items() if name != field))
        rows[others][result.values[field]] = found
    return [[row[each] for each in sorted(row, key=float)] for row in rows.values() if len(row) > 1]


def _check(trend: Trend, rows: Sequence[Sequence[Measured]]) -> TrendCheck:
    sign = 1 if trend.rises else -1
    steps = [sign * ((after.value or 0.0) - (before.value or 0.0)) for row in rows for before, after in pairwise(row)]
    first, last = (columns_of([row[place] for row in rows]) for place in (0, -1))
    changes = last[0] - first[0]
    spreads = np.hypot(first[2] - first[1], last[2] - last[1]) / 2  # NaN where one of them has no interval
    is_right, is_beyond = sign * changes > 0, np.abs(changes) > spreads
    change, half = float(changes.mean()), float(np.sqrt(np.sum(spreads**2))) / len(rows)
    return TrendCheck(
        **asdict(trend),
        series=len(rows),
        steps=len(steps),
        steps_right=sum(step > 0 for step in steps),
        ends_right=int(is_right.sum()),
        ends_clear=int((is_right & is_beyond).sum()),
        ends_contrary=int((~is_right & is_beyond).sum()),
        change=change,
        low=change - half if np.isfinite(half) else None,
        high=change + half if np.isfinite(half) else None,
    )


APART, ALIKE, SATURATED = "told apart", "indistinguishable", "saturated"


def columns_of(found: Sequence[Measured]) -> Array:
    """Value, low and high of each, shape (3, designs); NaN for what there is none of."""
    rows = [(each.value, each.low, each.high) for each in found]
    return np.array(rows, dtype=float).reshape(-1, 3).T


def is_clear(larger: Array, smaller: Array, pairs: int) -> Mask:
    """Whether values are above others beyond the interval of their difference, each of so many pairs.

    Both have shape (3,) or (3, designs), see `columns_of`.
    """
    normal = NormalDist()
    wider = normal.inv_cdf(TAIL / max(pairs, 1)) / normal.inv_cdf(TAIL)
    return np.asarray(larger[0] - smaller[0] > wider * np.hypot(larger[0] - larger[1], smaller[2] - smaller[0]))


def verdicts(results: Sequence[DesignResult], measures: Sequence[str]) -> dict[str, str]:
    """`told apart`, `indistinguishable` or `saturated` of each measure that two designs or more have.

    Saturated: every design has a bound on one side, or, of what is not exact, one value.
    """
    told = {}
    for name in measures:
        found = columns_of([result.measures[name] for result in _with_value(results, name)])
        count = found.shape[1]
        if count < 2:  # noqa: PLR2004 - a pair
            continue
        is_bound = np.isnan(found[1]).all() != np.isnan(found[2]).all()
        if is_bound or (not np.ptp(found[0]) and not MEASURES[name].is_exact):
            told[name] = SATURATED
        elif any(is_clear(each, found, count * (count - 1) // 2).any() for each in found.T):
            told[name] = APART
        else:
            told[name] = ALIKE
    return told


def leaders(results: Sequence[DesignResult], objectives: Sequence[Objective]) -> list[DesignResult]:
    """Designs that are clearly behind no other one in the first objective, of those the same in the second, and so on.

    A single one is the best; none where no design has a value of the first objective.
    """
    left = _with_value(results, objectives[0].measure) if objectives else []
    for each in objectives:
        known = _with_value(left, each.measure)
        if known:
            found = columns_of([result.measures[each.measure] for result in known])
            is_high = each.direction == "higher"
            first = found[:, np.argmax(found[0]) if is_high else np.argmin(found[0])][:, None]
            behind = is_clear(*((first, found) if is_high else (found, first)), len(known) - 1)
            left = [result for result, is_behind in zip(known, behind, strict=True) if not is_behind]
    return left


def _with_value(results: Sequence[DesignResult], name: str) -> list[DesignResult]:
    return [each for each in results if name in each.measures and each.measures[name].value is not None]
