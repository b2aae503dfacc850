"""Percentile intervals by drawing again with replacement (Efron and Tibshirani 1993)."""

from collections.abc import Callable, Sequence

import numpy as np

from magicsim.arrays import Index
from magicsim.sweep.judging.measures import Measured

Statistic = Callable[[Index], float]
"""Takes numbers of the drawn items, with repetition; NaN where it is not defined."""
CONFIDENCE = 0.95
RESAMPLES = 400


def interval(renderings: Sequence[Statistic], count: int, *, seed: int) -> tuple[float, float]:
    """Ends of the 95 % interval of a statistic's mean over independent renderings.

    Renderings are drawn, and in each drawn one its items. Of what n renderings differ by, drawing among them sees
    (n - 1) / n.

    Args:
        renderings: What is estimated from the items of each.
        count: How many items each has.
        seed: Of the draws.

    Returns:
        NaN twice where the statistic is never defined.
    """
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, count])))

    def drawn() -> float:
        # A single rendering takes nothing from the stream of its items.
        chosen = random.integers(0, len(renderings), len(renderings)) if len(renderings) > 1 else [0]
        return float(np.mean([renderings[number](random.integers(0, count, count)) for number in chosen]))

    values = np.array([drawn() for _ in range(RESAMPLES)])
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan"), float("nan")
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(values, [tail, 1 - tail])
    return float(low), float(high)


def mean_over(renderings: Sequence[Statistic], count: int, *, seed: int) -> Measured:
    """A statistic of all items, mean over renderings, with its interval (see `interval`)."""
    low, high = interval(renderings, count, seed=seed)
    value = float(np.mean([statistic(np.arange(count)) for statistic in renderings]))
    return Measured(value=value, low=low, high=high)
