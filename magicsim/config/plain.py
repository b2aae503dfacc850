"""Plain values as JSON has them."""

import math
from collections.abc import Mapping
from typing import Any


def without_nan(value: Any) -> Any:  # noqa: ANN401 - any nesting that JSON has
    """The value with None where a number is none or infinite, for which JSON has no word."""
    if isinstance(value, Mapping):
        return {key: without_nan(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
