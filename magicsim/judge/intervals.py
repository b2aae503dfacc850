"""The intervals of everything that is judged: of what is resampled, of shares and of counts.

Percentile intervals by drawing with replacement (Efron and Tibshirani 1993), on one level or two, of a detector's
measures over whole episodes (Field and Welsh 2007); exact ones of a share of independent trials (Clopper and Pearson
1934) and of a Poisson count (Garwood 1936), which stand also where nothing spreads.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.judge.measures import measure, measured
from magicsim.judge.tally import Tally

Statistic = Callable[[Index], float]
"""Takes numbers of the drawn items, with repetition; NaN where it is not defined."""
CONFIDENCE = 0.95
TAIL = (1 - CONFIDENCE) / 2
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
    low, high = np.quantile(values, [TAIL, 1 - TAIL])
    return float(low), float(high)


def count_ends(events: int) -> tuple[float, float]:
    """Ends of the exact interval of the expected count, where so many independent events were counted."""
    from scipy.special import gammaincinv

    low = float(gammaincinv(events, TAIL)) if events else 0.0
    return low, float(gammaincinv(events + 1, 1 - TAIL))


LEAST_EPISODES = 3
"""Fewer episodes give no interval: their spread says nothing of other episodes."""
MOST_UNDEFINED = 0.2
"""Share of resamples in which a measure may be undefined, because a class is missing, before its interval is None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureEstimate:
    """A measure with its confidence interval."""

    value: float | None
    """None where a class has no frames."""
    low: float | None
    high: float | None
    """Ends of the 95 % percentile interval; None of fewer than three episodes."""
    episodes: int


def weights_of(indices: Index, episodes: int) -> Array:
    """How often each episode was drawn, shape (resamples, episodes), by indices of shape (resamples, draws)."""
    rows = np.repeat(np.arange(len(indices)), indices.shape[1])
    counts = np.bincount(rows * episodes + indices.ravel(), minlength=len(indices) * episodes)
    return counts.reshape(-1, episodes).astype(np.float64)


def estimate(name: str, table: Tally, groups: Sequence[str], *, resamples: int, seed: int) -> MeasureEstimate:
    """One measure of a tally with its interval; episodes of one group are drawn together, since they share a take."""
    value = measure(name, table)
    labels = list(dict.fromkeys(groups))
    low = high = None
    if value is not None and len(labels) >= LEAST_EPISODES:
        member = np.array([[label == group for group in groups] for label in labels], np.float64)
        drawn = weights_of(resampled(len(labels), resamples, np.random.default_rng(seed)), len(labels))
        with np.errstate(invalid="ignore"):
            found = measured(name, table, drawn @ member)
        if np.isnan(found).mean() <= MOST_UNDEFINED:
            low, high = ends(found)
    return MeasureEstimate(value=value, low=low, high=high, episodes=len(labels))


def exact_share(successes: int, total: int) -> MeasureEstimate:
    """A share of independent trials, where the bootstrap has nothing to spread once all are alike."""
    if total == 0:
        return MeasureEstimate(value=None, low=None, high=None, episodes=0)
    from scipy.stats import binomtest

    found = binomtest(successes, total).proportion_ci(CONFIDENCE, method="exact")
    return MeasureEstimate(value=successes / total, low=float(found.low), high=float(found.high), episodes=total)
