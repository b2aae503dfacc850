"""What a learning curve promises beyond its last point: a power law of the number of training frames.

Errors of learned models fall as a power of the amount of data between a region of small data and a floor that no data
removes (Hestness et al. 2017, arXiv 1712.00409). Two or three points cannot tell the floor, so that none is fitted:
what comes out is too low where the floor is near.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.sampling.bootstrap import ends
from magicsim_experiments.learn.scores import RESAMPLES

LEAST_POINTS = 2
"""Points that a power law goes through."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoint:
    """Errors of frames that were answered after training on so many."""

    train_frames: float
    errors: Array
    """Absolute errors, shape (n,); NaN where there is no label."""
    press: Index
    """Press of each, shape (n,)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Promise:
    """An extrapolated error, with what it may be for other presses."""

    train_frames: float
    value: float
    low: float
    """Ends of the 95 % percentile interval, presses drawn again with replacement, the same ones at every point."""
    high: float
    exponent: float
    """Power with which the error falls; below 0 where it rises."""


def fit_power_law(train_frames: Array, errors: Array) -> tuple[Array, Array]:
    """Factor and exponent of `error = factor * frames ** -exponent`, least squares of the logarithms.

    Args:
        train_frames: Shape (points,), two of them different at least.
        errors: Shape (..., points), above 0.

    Returns:
        Factors and exponents, shape (...).
    """
    x, y = np.log(train_frames), np.log(errors)
    middle = x - x.mean()
    exponent = -(y * middle).sum(-1) / (middle**2).sum()
    return np.exp(y.mean(-1) + exponent * x.mean()), exponent


def promise(points: Sequence[CurvePoint], train_frames: Sequence[float], *, seed: int) -> list[Promise]:
    """Errors after training on more frames, as the curve's power law has them.

    Args:
        points: Of the curve.
        train_frames: How many frames are asked for.
        seed: Of the resampling.

    Returns:
        Nothing where fewer than two points differ in their frames, or an error is 0.
    """
    frames = np.array([point.train_frames for point in points])
    if len(np.unique(frames)) < LEAST_POINTS:
        return []
    presses = np.unique(np.concatenate([point.press for point in points]))
    sums, counts = np.zeros((2, len(points), len(presses)))
    for place, point in enumerate(points):
        there = np.isfinite(point.errors)
        member = np.searchsorted(presses, point.press[there])
        sums[place] = np.bincount(member, point.errors[there], minlength=len(presses))
        counts[place] = np.bincount(member, minlength=len(presses))
    random = np.random.default_rng([seed, len(presses)])
    weights = random.multinomial(len(presses), np.full(len(presses), 1 / len(presses)), size=RESAMPLES)
    drawn_counts, drawn_sums = weights @ counts.T, weights @ sums.T
    has_errors = (drawn_sums > 0).all(1)
    if not (sums.sum(1) > 0).all() or not has_errors.any():
        return []
    drawn = drawn_sums[has_errors] / drawn_counts[has_errors]
    factor, exponent = fit_power_law(frames, sums.sum(1) / counts.sum(1))
    factors, exponents = fit_power_law(frames, drawn)
    found = []
    for count in train_frames:
        low, high = ends(factors * count**-exponents)
        found.append(
            Promise(
                train_frames=count, value=float(factor * count**-exponent), low=low, high=high, exponent=float(exponent)
            )
        )
    return found
