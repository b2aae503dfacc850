"""Designs that no other design beats in all objectives."""

from collections.abc import Sequence

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import Objective


def costs_of(results: Sequence[DesignResult], objectives: Sequence[Objective]) -> Array:
    """What each design is to keep small, shape (designs, objectives); NaN where a measure has no value."""
    rows = []
    for result in results:
        values = [
            result.measures[each.measure].value if each.measure in result.measures else None for each in objectives
        ]
        rows.append(
            [np.nan if v is None else -v if o.way == "higher" else v for v, o in zip(values, objectives, strict=True)]
        )
    return np.array(rows, float).reshape(len(results), len(objectives))


def pareto_front(costs: Array) -> Mask:
    """Which designs no other one equals or beats in every objective and beats in one, shape (designs,).

    Args:
        costs: Shape (designs, objectives); a design with a NaN is in no front, and without objectives there is none.
    """
    known = np.asarray(np.isfinite(costs).all(1) & (costs.shape[1] > 0))
    result = np.array(known)
    for index in np.flatnonzero(known):
        others = costs[known]
        beaten = (others <= costs[index]).all(1) & (others < costs[index]).any(1)
        result[index] = not beaten.any()
    return result


def best_of(results: Sequence[DesignResult], objectives: Sequence[Objective]) -> DesignResult | None:
    """The design that is best in the first objective, the others deciding between equals; None without a value."""
    if not objectives:
        return None
    costs = costs_of(results, objectives)
    known = np.flatnonzero(np.isfinite(costs[:, 0]))
    if not len(known):
        return None
    filled = np.where(np.isfinite(costs), costs, np.inf)
    order = np.lexsort(filled[known].T[::-1])
    return results[int(known[order[0]])]
