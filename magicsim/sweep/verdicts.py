"""What a measure says of a sweep as a whole: whether it tells designs apart, and whether one of them is best.

Two designs are told apart where their values differ by more than the interval of the difference, sqrt(a^2 + b^2) with
the parts a and b of their own intervals that face each other (Zou and Donner, Stat. Med. 27 (2008) 1693). Among n
designs some pair differs by chance: intervals are widened to the level 0.05 / m, m the number of pairs that are looked
at (Bonferroni), as if they were of Gaussian errors. A bound, whose interval is open, reaches to infinity on that side.
"""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.judge.intervals import TAIL
from magicsim.sweep.measures import MEASURES, Measured
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import Objective

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
