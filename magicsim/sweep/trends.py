"""Published trends, checked on the designs of a sweep that differ in one field alone.

A thicker skin or a thinner core is harder (Fan, Li, Zhang, arXiv 2505.24382, and its predecessor arXiv 2402.01366);
a thicker skin is less sensitive. Sensitive means to a force: at the same depth a thicker skin may even disturb the grid
more, since it takes a larger force to get there.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from magicsim.sweep.result import DesignResult

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
    Trend(statement="thicker skin, less sensitive to force", field=SKIN, measure="sensitivity_per_n", rises=False),
    Trend(statement="deeper core, softer", field=CORE, measure="shore_a", rises=False),
    Trend(statement="deeper core, less stiff", field=CORE, measure="force_1mm_n", rises=False),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrendCheck:
    """How far a sweep bears a trend out."""

    statement: str
    field: str
    measure: str
    series: int
    """Rows of designs that differ in the field alone."""
    steps: int
    """Neighbours in them."""
    steps_right: int
    """Neighbours that differ the right way."""
    ends_right: int
    """Rows whose last design differs from the first the right way."""

    @property
    def holds(self) -> bool:
        """Whether every row goes the right way from end to end."""
        return self.series > 0 and self.ends_right == self.series


def check_trends(results: Sequence[DesignResult]) -> list[TrendCheck]:
    """Every published trend that some row of designs can show."""
    checks = []
    for trend in TRENDS:
        rows = series(results, trend.field, trend.measure)
        sign = 1 if trend.rises else -1
        steps = [sign * (after - before) for row in rows for before, after in pairwise(row)]
        if rows:
            checks.append(
                TrendCheck(
                    statement=trend.statement,
                    field=trend.field,
                    measure=trend.measure,
                    series=len(rows),
                    steps=len(steps),
                    steps_right=sum(step > 0 for step in steps),
                    ends_right=sum(sign * (row[-1] - row[0]) > 0 for row in rows),
                )
            )
    return checks


def series(results: Sequence[DesignResult], field: str, measure: str) -> list[list[float]]:
    """Values of a measure along a field, one row for each choice of all other fields, of two designs or more."""
    names = {name for result in results for name in result.values}
    if field not in names:
        return []
    rows: dict[tuple[object, ...], dict[float, float]] = defaultdict(dict)
    for result in results:
        found = result.measures.get(measure)
        if found is None or found.value is None or field not in result.values:
            continue
        others = tuple(sorted((name, value) for name, value in result.values.items() if name != field))
        rows[others][result.values[field]] = found.value
    return [[row[each] for each in sorted(row)] for row in rows.values() if len(row) > 1]
