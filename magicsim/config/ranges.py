"""Numbers that come as arguments, checked as those of configuration files are."""

import math
import numbers
from collections.abc import Iterable

from magicsim.errors import ConfigError


def check_number(name: str, value: float, low: float, high: float, *, whole: bool = False) -> None:
    """Refuses (`ConfigError`) a number that is not finite, not whole where asked for, or outside of a range."""
    allowed = f"must be a {'whole number' if whole else 'number'} of at least {low:g} and at most {high:g}"
    if not is_number(value):
        raise ConfigError(f"{name} = {value!r} is not allowed: {allowed}")
    if not (math.isfinite(value) and low <= value <= high and (not whole or value == int(value))):
        raise ConfigError(f"{name} = {value:g} is not allowed: {allowed}")


def check_vector(name: str, value: object, low: float, high: float, *, length: int = 3) -> None:
    """Refuses (`ConfigError`) what is no row of so many finite numbers in a range."""
    parts = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else []
    if len(parts) != length:
        raise ConfigError(f"{name} = {value!r} is not allowed: must be {length} numbers")
    for each in parts:
        check_number(name, each, low, high)


def is_number(value: object) -> bool:
    """Whether something is a real number of Python or NumPy; true and false are none."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)
