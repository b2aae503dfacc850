"""Confidence intervals by the bootstrap over whole episodes (Efron and Tibshirani 1993; Field and Welsh 2007)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest, bootstrap

from magicsim.arrays import Array, Index
from magicsim.evaluation.statistics.measures import MEASURES, measure
from magicsim.evaluation.statistics.tally import Tally
from magicsim.sampling.bootstrap import CONFIDENCE, ends

LEAST_EPISODES = 3
"""Fewer episodes give no interval: their spread says nothing of other episodes."""
MOST_UNDEFINED = 0.2
"""Share of resamples in which a measure may be undefined, because a class is missing, before its interval is None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A measure with its confidence interval."""

    value: float | None
    """None where a class has no frames."""
    low: float | None
    high: float | None
    """Ends of the 95 % percentile interval; None of fewer than three episodes."""
    episodes: int


def weights_of(indices: Index, episodes: int) -> Array:
    """How often each episode was drawn: indices of shape (..., draws) to weights of shape (..., episodes)."""
    flat = indices.reshape(-1, indices.shape[-1])
    rows = np.repeat(np.arange(len(flat)), flat.shape[1])
    counts = np.bincount(rows * episodes + flat.ravel(), minlength=len(flat) * episodes)
    return counts.reshape(*indices.shape[:-1], episodes).astype(np.float64)


def estimate(name: str, table: Tally, groups: Sequence[str], *, resamples: int, seed: int) -> Estimate:
    """One measure of a tally with its interval.

    Args:
        name: A key of `MEASURES`.
        table: The episodes.
        groups: One label an episode; episodes of one label are drawn together, since they share a take.
        resamples: Number of bootstrap resamples.
        seed: Of the resampling.
    """
    value = measure(name, table)
    labels = list(dict.fromkeys(groups))
    low = high = None
    if value is not None and len(labels) >= LEAST_EPISODES:
        member = np.array([[label == group for group in groups] for label in labels], np.float64)

        def statistic(indices: Index, axis: int = -1) -> Array:
            drawn = weights_of(np.moveaxis(indices, axis, -1).astype(np.int64), len(labels))
            values = MEASURES[name].compute(table, drawn.reshape(-1, len(labels)) @ member)
            return values.reshape(drawn.shape[:-1])

        with np.errstate(invalid="ignore"):
            found = bootstrap(
                (np.arange(len(labels)),), statistic, n_resamples=resamples, vectorized=True, method="percentile",
                rng=np.random.default_rng(seed),
            ).bootstrap_distribution  # fmt: skip
        if np.isnan(found).mean() <= MOST_UNDEFINED:
            low, high = ends(found)
    return Estimate(value=value, low=low, high=high, episodes=len(labels))


def exact_share(successes: int, total: int) -> Estimate:
    """A share of independent episodes with its exact interval (Clopper and Pearson 1934).

    Where everything is right the bootstrap has nothing to spread and its interval collapses; this one does not.
    """
    if total == 0:
        return Estimate(value=None, low=None, high=None, episodes=0)
    ends = binomtest(successes, total).proportion_ci(CONFIDENCE, method="exact")
    return Estimate(value=successes / total, low=float(ends.low), high=float(ends.high), episodes=total)
