"""Least squares over the unit cube with few, costly evaluations, and what the data say of each unknown.

Gauss-Newton with a trust region and bounds (scipy's `trf`: Branch, Coleman and Li 1999). Derivatives are differences
over a fixed share of each range: large against what is left of the rendering's noise, small against the range.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from magicsim.arrays import Array

Residuals = Callable[[Array], Array]
STEP = 0.06
"""Share of a range over which a derivative is taken."""
UNKNOWN_SD = 12**-0.5
"""Standard deviation of what is known of nothing: even over its range."""
DETERMINED_SD = 0.1
"""Below this share of its range an unknown counts as determined."""
TOLERANCE = 2e-3
"""The search ends where a step changes neither point nor sum of squares by more than this share."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """The best point that was found, and how well the data hold it there."""

    point: Array
    """Shape (unknowns,), in 0..1."""
    rms: float
    """Root mean square residual there, in the residuals' unit."""
    sd: Array
    """Standard deviation of each unknown in shares of its range, at most `UNKNOWN_SD`."""
    jacobian: Array
    """Shape (residuals, unknowns) [residuals' unit for the whole range]."""
    singular_values: Array
    """Singular values of the Jacobian, largest first [residuals' unit for the whole range]."""
    weakest: Array
    """Unit vector along which the residuals change least, shape (unknowns,)."""
    ends: Array
    """Where each start ended, shape (starts, unknowns)."""
    ends_rms: list[float]
    evaluations: int


def solve(residuals: Residuals, start: Array, *, starts: int, evaluations: int, seed: int) -> Solution:
    """Finds the least squares from several starts."""
    known: dict[bytes, Array] = {}

    def evaluate(point: Array) -> Array:
        key = np.round(point, 12).tobytes()
        if key not in known:
            known[key] = residuals(point)
        return known[key]

    def jacobian(point: Array) -> Array:
        return differences(evaluate, point)

    sampler = qmc.Sobol(len(start), rng=np.random.default_rng(seed))
    points = [np.clip(start, 1e-3, 1 - 1e-3), *(sampler.random(1)[0] for _ in range(starts - 1))]
    found = [
        least_squares(
            evaluate, point, jac=jacobian, bounds=(0, 1), max_nfev=evaluations, xtol=TOLERANCE, ftol=TOLERANCE
        )
        for point in points
    ]
    best = min(found, key=lambda each: float(each.cost))
    slopes = jacobian(best.x)
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    return Solution(
        point=best.x, rms=_rms(best.fun), sd=deviations(slopes, best.fun), jacobian=slopes, singular_values=singular,
        weakest=directions[-1], ends=np.array([each.x for each in found]), ends_rms=[_rms(each.fun) for each in found],
        evaluations=len(known),
    )  # fmt: skip


def differences(residuals: Residuals, point: Array) -> Array:
    """Jacobian by differences of `STEP`, one-sided at the faces of the cube, shape (residuals, unknowns)."""
    columns = []
    for place in range(len(point)):
        low, high = point.copy(), point.copy()
        low[place], high[place] = max(point[place] - STEP, 0), min(point[place] + STEP, 1)
        columns.append((residuals(high) - residuals(low)) / (high[place] - low[place]))
    return np.stack(columns, axis=1)


def deviations(jacobian: Array, residuals: Array) -> Array:
    """Standard deviation of each unknown, with an even prior over its range.

    Gaussian: the inverse of J' J / s^2 + 12, where s^2 is the residuals' variance with as many degrees of freedom as
    there are more residuals than unknowns, and 12 the inverse variance of an even distribution over 0..1. Residuals of
    neighbouring blocks are alike where the model itself is off, so that it is the least that can be said.
    """
    free = max(1, len(residuals) - jacobian.shape[1])
    variance = max(float(residuals @ residuals) / free, np.finfo(float).tiny)
    covariance = np.linalg.inv(jacobian.T @ jacobian / variance + np.eye(jacobian.shape[1]) / UNKNOWN_SD**2)
    return np.asarray(np.sqrt(np.diag(covariance)))


def scatter(jacobian: Array, residuals: Sequence[Array]) -> Array:
    """How far each unknown would move with other noise of the model: shape (unknowns,), in shares of the ranges.

    Standard deviation of the Gauss-Newton steps that two or more independent residuals of one point ask for, with an
    even prior; the Jacobian at that point has shape (residuals, unknowns).
    """
    variance = max(float(np.mean([each @ each for each in residuals])) / jacobian.shape[0], np.finfo(float).tiny)
    normal = jacobian.T @ jacobian + variance * np.eye(jacobian.shape[1]) / UNKNOWN_SD**2
    steps = [np.linalg.solve(normal, jacobian.T @ each) for each in residuals]
    return np.asarray(np.std(steps, axis=0, ddof=1))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
