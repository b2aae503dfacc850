"""How far fingers close: to where they are told, or until the larger normal force is that of their motors."""

from collections.abc import Callable

from scipy.optimize import brentq

CREEP_MM = 0.4
"""Longest way of the faces towards each other between two equilibria once they touch [mm]."""
TOLERANCE = 0.01
"""Difference from the motors' force at which they stand, in units of it."""
FINEST_MM = 1e-5
"""Interval of distances at which the search for it ends in any case [mm]."""


def close_until(
    force_n: Callable[[float], float], keep: Callable[[], None], start: tuple[float, float], target_mm: float,
    limit_n: float,
) -> bool:  # fmt: skip
    """Closes the fingers step by step; they are left where they stand.

    Args:
        force_n: Brings the faces from where they were kept last to a distance, and gives the larger normal force [N].
        keep: The faces as they are now become those that `force_n` starts from.
        start: Distance of the faces where they stand [mm], at which they touch the object or will soon, and force [N].
        target_mm: Where to, not above it [mm].
        limit_n: Normal force at which the motors stall [N].

    Returns:
        Whether the motors stalled on the way.
    """
    width, pressed = start
    if pressed > limit_n:
        return True
    while width > target_mm:
        tried = max(width - CREEP_MM, target_mm)
        found = force_n(tried)
        if found > limit_n:
            _stall(force_n, (tried, found), (width, pressed), limit_n)
            return True
        keep()
        width, pressed = tried, found
    return False


def _stall(
    force_n: Callable[[float], float], closer: tuple[float, float], wider: tuple[float, float], limit_n: float
) -> None:
    """Goes to where the force is the limit, between the distance where the faces are, above it, and one below it."""
    known, stands = dict([closer, wider]), closer[0]

    def excess_n(width_mm: float) -> float:
        nonlocal stands
        if width_mm not in known:
            known[width_mm], stands = force_n(width_mm), width_mm
        found = known[width_mm] - limit_n
        return 0.0 if abs(found) <= TOLERANCE * limit_n else found

    width = float(brentq(excess_n, closer[0], wider[0], xtol=FINEST_MM))
    if width != stands:
        force_n(width)
