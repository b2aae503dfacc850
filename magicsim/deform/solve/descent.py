"""What a Newton iteration is made of, whatever it solves: a matrix that is definite, and a step that leads down.

Shared by the whole problem (`newton`, `line_search`) and by the small one of the face (`face_problem`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
ARMIJO = 1e-4
"""Least decrease in units of the one that the slope promises."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stiffening:
    """What makes a matrix definite."""

    curvature_limit: float
    """Largest pressure times curvature of the object that counts [N/mm3]."""
    shift: float
    """Multiple of a definite matrix that is added."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shifts:
    """Multiples that are tried in turn."""

    first: float
    """Least that is tried after 0."""
    growth: float
    """Each over the one before."""
    last: float
    """At which to give up."""


def stiffenings(shifts: Shifts, *, cautious: float, is_near: bool, shift: float = 0.0) -> Iterator[Stiffening]:
    """What to try in turn until a matrix is definite: nothing, then a bound of the curvature, then shifts.

    Args:
        shifts: Multiples.
        cautious: The bound [N/mm3].
        is_near: Whether equilibrium is so near that the object's curvature may count in full.
        shift: Where to begin.
    """
    if is_near:
        yield Stiffening(curvature_limit=np.inf, shift=shift)
    while shift <= shifts.last:
        yield Stiffening(curvature_limit=cautious, shift=shift)
        shift = max(shifts.first, shifts.growth * shift)


def decreases(value: float, reference: float, promised: float, noise: float) -> bool:
    """Whether an energy has decreased enough.

    Args:
        value: After the step [mJ].
        reference: Before it [mJ].
        promised: Change that the slope promises, negative [mJ].
        noise: Rounding of either [mJ].
    """
    return value <= reference + ARMIJO * promised + noise


def shortened(
    accepts: Callable[[Any, float], bool], trial: Callable[[float], T | None], *, longest: float, halvings: int
) -> tuple[T | None, float, bool]:
    """The longest acceptable step among halved ones.

    Args:
        accepts: Whether a trial will do.
        trial: What a part of the step leads to; None where that is nowhere.
        longest: Part to begin with.
        halvings: Trials.

    Returns:
        What was found, the part of the step, and whether it was accepted: the last trial that led somewhere otherwise.
    """
    alpha, best, part = longest, None, 0.0
    for _ in range(halvings):
        found = trial(alpha)
        if found is not None:
            best, part = found, alpha
            if accepts(found, alpha):
                return best, part, True
        alpha /= 2
    return best, part, False
