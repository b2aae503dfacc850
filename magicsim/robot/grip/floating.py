"""An object without weight that moves along the closing axis until both normal forces are equal."""

from collections.abc import Callable
from dataclasses import replace

from scipy.optimize import brentq

from magicsim.robot.fingers import ObjectPlace, half_extents_mm
from magicsim.robot.grip.pair import FingerPair, Moments

BALANCE_N = 0.01
"""Difference of the two normal forces at which a floating object rests [N]."""
FINEST_MM = 1e-6
"""Interval of places at which the search for balance ends in any case [mm]."""
HERTZ = 1.5
"""Power of the depth with which a contact's force rises (Hertz), by which the first step towards balance is guessed."""
BEYOND = 1.3
"""How far the step after the guess goes, in units of the secant's, so that balance lies before its end."""


def contacts_mm(pair: FingerPair, place: ObjectPlace, width_mm: float) -> tuple[float, float]:
    """Heights of the object at which it just touches the lower and the upper finger [mm]; none where not in order."""
    up, down = half_extents_mm(pair.target, place)
    return down - width_mm / 2, width_mm / 2 - up


def float_between(pair: FingerPair, place: ObjectPlace, width_mm: float) -> ObjectPlace:
    """Where the object comes to rest; the fingers are left there.

    Raises:
        ConfigError: The object would leave a finger's workspace.
        ConvergenceError: No valid equilibrium was found.
    """
    touches_lower, touches_upper = contacts_mm(pair, place, width_mm)
    if touches_lower <= touches_upper:  # room for the object: a finger that touches it pushes it away
        settled = replace(place, z_mm=min(max(place.z_mm, touches_lower), touches_upper))
        pair.put(settled, width_mm)
        return settled
    before = pair.moments()
    deepest = -pair.upper.workspace.gap_mm[0]
    low, high = max(touches_upper, touches_lower - deepest), min(touches_lower, touches_upper + deepest)
    tried: dict[float, tuple[float, Moments]] = {}

    def imbalance_n(z_mm: float) -> float:
        """Difference of the normal forces with the object at a place, 0 where they balance; fingers stay there."""
        if z_mm not in tried:
            pair.go_back(before)
            pair.put(replace(place, z_mm=z_mm), width_mm)
            found = float(pair.upper.deformation.force_n[2] - pair.lower.deformation.force_n[2])
            tried[z_mm] = (0.0 if abs(found) <= BALANCE_N else found, pair.moments())
        value, moments = tried[z_mm]
        pair.go_back(moments)
        return value

    settled_mm = (low + high) / 2
    at_middle = imbalance_n(settled_mm)
    if at_middle != 0:
        both_n = float(pair.upper.deformation.force_n[2] + pair.lower.deformation.force_n[2])
        guess = settled_mm - at_middle * (touches_lower - touches_upper) / 2 / (HERTZ * both_n)
        ends = _around(imbalance_n, settled_mm, min(max(guess, low), high), (low, high))
        if imbalance_n(ends[0]) <= 0 <= imbalance_n(ends[1]):
            settled_mm = float(brentq(imbalance_n, *ends, xtol=FINEST_MM))
        else:  # as near to balance as the workspace lets it come
            settled_mm = ends[0] if at_middle > 0 else ends[1]
        imbalance_n(settled_mm)
    return replace(place, z_mm=settled_mm)


def _around(
    imbalance_n: Callable[[float], float], middle_mm: float, guess_mm: float, farthest_mm: tuple[float, float]
) -> tuple[float, float]:
    """Two places with balance between them, near a guess where that is good: no finger is pressed deeply for nothing.

    Args:
        imbalance_n: Difference of the normal forces at a place, which rises with it [N].
        middle_mm: A place that is out of balance.
        guess_mm: Where balance may be.
        farthest_mm: Smallest and largest place; the one on the side of balance is taken where guesses fall short of it.
    """
    at_middle, at_guess = imbalance_n(middle_mm), imbalance_n(guess_mm)
    if at_guess * at_middle > 0 and at_guess != at_middle:
        step = BEYOND * at_guess * (guess_mm - middle_mm) / (at_guess - at_middle)
        middle_mm, guess_mm = guess_mm, min(max(guess_mm - step, farthest_mm[0]), farthest_mm[1])
        at_guess = imbalance_n(guess_mm)
    if at_guess * at_middle > 0:
        guess_mm = farthest_mm[0] if at_middle > 0 else farthest_mm[1]
    return min(middle_mm, guess_mm), max(middle_mm, guess_mm)
