"""An object without weight that moves along the closing axis until both normal forces are equal."""

from dataclasses import replace

from scipy.optimize import brentq

from magicsim.robot.fingers import ObjectPlace, half_extents_mm
from magicsim.robot.grip.pair import Moments, Pair

BALANCE_N = 0.01
"""Difference of the two normal forces at which a floating object rests [N]."""
FINEST_MM = 1e-6
"""Interval of places at which the search for balance ends in any case [mm]."""


def contacts_mm(pair: Pair, place: ObjectPlace, width_mm: float) -> tuple[float, float]:
    """Heights of the object at which it just touches the lower and the upper finger [mm]; no room where not in order.

    Args:
        pair: The fingers.
        place: The object's; its height does not matter.
        width_mm: Distance between the contact faces [mm].
    """
    up, down = half_extents_mm(pair.target, place)
    return down - width_mm / 2, width_mm / 2 - up


def float_between(pair: Pair, place: ObjectPlace, width_mm: float) -> ObjectPlace:
    """Where the object comes to rest; the fingers are left there.

    Args:
        pair: The fingers.
        place: Where the object comes from.
        width_mm: Distance between the contact faces [mm].

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
        ends = (low, settled_mm) if at_middle > 0 else (settled_mm, high)
        if imbalance_n(ends[0]) < 0 < imbalance_n(ends[1]):
            settled_mm = float(brentq(imbalance_n, *ends, xtol=FINEST_MM))
        else:  # as near to balance as the workspace lets it come
            settled_mm = ends[0] if at_middle > 0 else ends[1]
        imbalance_n(settled_mm)
    return replace(place, z_mm=settled_mm)
