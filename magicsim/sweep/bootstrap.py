"""Percentile intervals by drawing again with replacement (Efron and Tibshirani 1993)."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.int64]
Statistic = Callable[[Indices], float]
"""Takes numbers of the drawn items, with repetition; NaN where it is not defined."""
CONFIDENCE = 0.95
RESAMPLES = 400


def interval(statistic: Statistic, count: int, *, seed: int, resamples: int = RESAMPLES) -> tuple[float, float]:
    """Ends of the 95 % interval of a statistic.

    Args:
        statistic: What is estimated.
        count: How many items there are.
        seed: Of the draws.
        resamples: How often they are drawn.

    Returns:
        NaN twice where the statistic is never defined.
    """
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, count])))
    values = np.array([statistic(random.integers(0, count, count)) for _ in range(resamples)])
    values = values[np.isfinite(values)]
    if not len(values):
        return float("nan"), float("nan")
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(values, [tail, 1 - tail])
    return float(low), float(high)
