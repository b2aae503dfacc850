"""Numbers that come as arguments, checked as those of configuration files are."""

import math

from magicsim.errors import ConfigError


def check_number(name: str, value: float, low: float, high: float, *, whole: bool = False) -> None:
    """Refuses a number outside of a range.

    Args:
        name: What the user calls it.
        value: The number.
        low: Smallest that is allowed.
        high: Largest.
        whole: Whether it must be a whole number.

    Raises:
        ConfigError: It is not finite, not whole, or outside.
    """
    kind = "whole number" if whole else "number"
    if not (math.isfinite(value) and low <= value <= high and (not whole or value == int(value))):
        msg = f"{name} = {value:g} is not allowed: must be a {kind} of at least {low:g} and at most {high:g}"
        raise ConfigError(msg)
