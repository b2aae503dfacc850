"""Percentile intervals by drawing with replacement (Efron and Tibshirani 1993), on one level or two."""

from collections.abc import Callable, Sequence

import numpy as np

from magicsim.arrays import Array, Index

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

    return ends(np.array([drawn() for _ in range(RESAMPLES)]))


def resampled(count: int, resamples: int, random: np.random.Generator) -> Index:
    """Numbers of as many items as there are, drawn with replacement, shape (resamples, count)."""
    return random.integers(0, count, (resamples, count))


def ends(values: Array) -> tuple[float, float]:
    """Ends of the interval that resampled values say, those that are not finite left out; NaN twice where none is."""
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan"), float("nan")
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(values, [tail, 1 - tail])
    return float(low), float(high)
