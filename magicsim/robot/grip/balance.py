"""The place at which nothing pushes any more, of a body that friction holds: Newton steps with Broyden's updates.

Every trial starts from the state before, so that friction has the history of one straight motion. Where friction is
exhausted the body slides: its stiffness along the way vanishes, steps come to their longest, and the state is kept from
step to step. Whoever slides farther than `most_mm` is lost.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.errors import ConvergenceError

ITERATIONS = 40
"""Most trials of one search."""
SHORTENINGS = 4
"""How often a step is shortened that fails, or goes too far."""
WORSE = 1.5
"""What drives the body back after a step, in units of what drove it on before, above which the step is shortened; a
body that is still driven on goes on, however hard it is driven."""
SOFTEST = 0.02
"""Least stiffness along any direction, in units of the largest first estimate's."""


class Search(StrEnum):
    """How a search ended."""

    BALANCED = "balanced"
    """At rest within the tolerance."""
    LOST = "lost"
    """Slid farther than allowed."""
    AT_LIMIT = "at limit"
    """Driven on at a limit of its motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """When a search ends, and how far it may go."""

    tolerance_n: float
    """Largest component out of balance [N]."""
    longest_mm: float = 0.5
    """Longest step [mm]."""
    most_mm: float = 3.0
    """Way from the start beyond which the body is lost [mm]."""
    low: Array
    """Smallest place, shape (n,) [mm]."""
    high: Array
    """Largest place, shape (n,); a coordinate without any range is held [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """Where a search ended."""

    place: Array
    """Shape (n,) [mm]."""
    unbalanced: Array
    """Generalised force there, shape (n,) [N]."""
    search: Search
    trials: int
    """Evaluations of the force."""
    limit: int | None = None
    """The coordinate at whose limit it is driven on."""


def find_balance(
    unbalanced: Callable[[Array], Array], stiffness: Array, limits: Limits, *, keep: Callable[[], None]
) -> Balance:
    """Moves a body from 0 to where the force on it vanishes.

    Args:
        unbalanced: Force on the body at a place, both of shape (n,) [mm, N], rotations times a lever; the state behind
            is left there. It may raise ConvergenceError.
        stiffness: First estimate of how the force falls with the motion, shape (n, n) [N/mm].
        limits: When to end.
        keep: The state behind as it is now becomes the one that trials start from.

    Raises:
        ConvergenceError: The search did not end; the message has the figures.
    """
    matrix = np.array(stiffness, float)
    softest = SOFTEST * max(float(np.abs(np.diagonal(matrix)).max()), 1e-3)
    place, free = np.zeros(len(matrix)), limits.low < limits.high
    force, trials = unbalanced(place), 1
    while trials < ITERATIONS:
        if np.abs(force[free]).max(initial=0.0) <= limits.tolerance_n:
            return Balance(place=place, unbalanced=force, search=Search.BALANCED, trials=trials)
        step = _step(matrix, force, free, softest)
        length = float(np.linalg.norm(step))
        is_long = length >= limits.longest_mm
        step *= min(1.0, limits.longest_mm / max(length, 1e-30))
        for shortening in range(SHORTENINGS + 1):
            tried = np.clip(place + step, limits.low, limits.high)
            try:
                found, trials = unbalanced(tried), trials + 1
            except ConvergenceError:
                if shortening == SHORTENINGS:
                    raise
                trials += 1
            else:
                matrix = _updated(matrix, tried - place, force - found)
                overshoots = found @ (tried - place) < 0
                if not overshoots or np.linalg.norm(found[free]) <= WORSE * np.linalg.norm(force[free]):
                    break
            step, is_long = step / 2, False
        place, force = tried, found
        if is_long:
            keep()
        is_at_limit = (place <= limits.low) & (force < 0) | (place >= limits.high) & (force > 0)
        stopped = is_at_limit & free & (np.abs(force) > limits.tolerance_n)
        if stopped.any():
            return Balance(
                place=place, unbalanced=force, search=Search.AT_LIMIT, trials=trials, limit=int(stopped.argmax())
            )
        if np.linalg.norm(place) > limits.most_mm:
            return Balance(place=place, unbalanced=force, search=Search.LOST, trials=trials)
    msg = (
        f"the held object does not come to rest: {np.abs(force).max():.3g} N out of balance after {trials} trials, "
        f"{np.linalg.norm(place):.3g} mm from where it was"
    )
    raise ConvergenceError(msg)


def _step(matrix: Array, force: Array, free: Mask, softest: float) -> Array:
    """Newton's step where the stiffness is definite; otherwise one along the force, soft directions stiffened."""
    step = np.zeros(len(force))
    part = matrix[np.ix_(free, free)]
    values, vectors = np.linalg.eigh((part + part.T) / 2)
    if values.min(initial=np.inf) > softest:
        step[free] = np.linalg.solve(part, force[free])
    else:
        step[free] = vectors @ ((vectors.T @ force[free]) / np.maximum(values, softest))
    return step


def _updated(matrix: Array, moved: Array, fallen: Array) -> Array:
    """Broyden's update (1965) of the stiffness by what a step has shown."""
    size = float(moved @ moved)
    if size == 0:
        return matrix
    return np.asarray(matrix + np.outer(fallen - matrix @ moved, moved) / size)
