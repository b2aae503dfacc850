"""Where the carriage that carries the base stops in a step, and which of these places are taken as samples."""

import numpy as np

LONGEST_STEP_MM = 0.5
"""Longest way of the carriage between two equilibria while the pin may meet the base [mm]."""
FROM_MM = 8.0
"""From how far before the end of a step the base comes that was not there before it [mm]; assumed."""


def carriage_ways(start: float | None, end: float, samples: int) -> tuple[float, list[float]]:
    """Where the carriage may meet the base first, and its places from there, the last one being the end.

    Args:
        start: Where it was; None where it was not there.
        end: Where it goes [mm].
        samples: Places where it is not near the base.
    """
    if start is None or max(start, end) <= 0:
        first, count = end - FROM_MM, samples
    else:
        first = min(max(start, 0.0), end)
        count = max(1, int(np.ceil(abs(end - first) / LONGEST_STEP_MM - 1e-9)))
    return first, evenly_to(first, end, count)


def evenly_to(first: float, end: float, count: int) -> list[float]:
    """Places evenly on the way from a first one, which is left out, to the last."""
    return [first + (end - first) * (number + 1) / count for number in range(count)]


def spread(count: int, samples: int) -> list[int]:
    """How many of so many places have passed at each sample: whole numbers up to all of them."""
    return sorted({round(count * number / samples) for number in range(1, samples + 1)} - {0})
