"""How far answers are from the truth: mean absolute errors, with intervals over presses."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.sampling.bootstrap import ends, resampled

RESAMPLES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """A mean over frames, with what it may be for other presses."""

    value: float
    """Mean; NaN of no frames."""
    sd: float
    """Standard deviation over frames."""
    low: float
    high: float
    """Ends of the 95 % percentile interval of the mean, presses drawn again with replacement (Field and Welsh 2007)."""
    frames: int
    presses: int


def mean_score(values: Array, press: Index, *, seed: int = 0) -> Score:
    """Mean of a quantity of frames, such as an absolute error.

    Args:
        values: Shape (n,); NaN where it does not exist.
        press: Group of each frame that is drawn as a whole, shape (n,).
    """
    there = np.isfinite(values)
    values, press = values[there], press[there]
    if not len(values):
        nan = float("nan")
        return Score(value=nan, sd=nan, low=nan, high=nan, frames=0, presses=0)
    _, member = np.unique(press, return_inverse=True)
    sums, counts = np.bincount(member, values), np.bincount(member)
    random = np.random.default_rng([seed, len(values)])
    drawn = resampled(len(sums), RESAMPLES, random)
    means = sums[drawn].sum(1) / counts[drawn].sum(1)
    low, high = ends(means)
    return Score(
        value=float(values.mean()), sd=float(values.std()), low=low, high=high,
        frames=len(values), presses=len(sums),
    )  # fmt: skip
