"""Labels of recordings: sizes of forces of which parts may be unknown, and numbers that no such sensor has."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from magicsim.arrays import Array
from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, NEAR_MIN_MM

FELT_N = 0.05
"""Force above which something touches, where nothing says it directly [N]; assumed, the noise of a small sensor."""
MOST_N, MOST_DEPTH_MM, LEAST_DEPTH_MM = 200.0, 20.0, 0.01
"""Sizes that no sensor of this kind reaches: largest force [N], deepest press, and a deepest press below which none was
made [mm]."""
UNTARED_FRAMES, STEADY = 5, 0.2
"""First frames that are all in contact before anything else, and by how much of their median their force may differ."""
MOST_AT_ODDS = 0.1
"""Share of frames that touch by one label and not by the other."""


def force_size(parts: Sequence[float], *, felt_n: float = FELT_N) -> float:
    """Size of a force [N] whose parts may be NaN.

    With parts that are not known it is at least as large as the known ones: these, where that is a touch, else NaN.
    """
    known = [each for each in parts if not math.isnan(each)]
    size = math.hypot(*known)
    return size if known and (len(known) == len(parts) or size > felt_n) else math.nan


def odd_labels(*, force_n: Array, gap_mm: Array, felt_n: float = FELT_N, gap: str = "gap_mm") -> Iterator[str]:
    """What is odd about the labels of a recording, NaN where nobody knows, one line each that calls them by name."""
    known = force_n[~np.isnan(force_n)]
    depth = float(np.nanmax(-gap_mm, initial=-math.inf)) if not np.isnan(gap_mm).all() else -math.inf
    if len(known) and known.max() > MOST_N:
        yield f"force_n reaches {known.max():.4g} N, more than such a sensor bears: mN or grams? give N"
    if len(known) and 0 < known.max() <= felt_n:
        yield f"force_n reaches {known.max():.2g} N, which is no touch: kN or kg? give N"
    if 0 < depth < LEAST_DEPTH_MM:
        yield f"{gap} reaches a depth of {depth:.2g} mm, which is no press: metres? give mm"
    if depth > MOST_DEPTH_MM:
        yield f"{gap} reaches a depth of {depth:.4g} mm, more than the sensor is thick: micrometres? give mm"
    if (middle := _from_the_first(known, felt_n)) is not None:
        yield (
            f"force_n is {middle:.3g} N from the first frame on, a contact before anything touches: not tared? "
            "subtract what an untouched sensor shows"
        )
    depths = -gap_mm[~np.isnan(gap_mm)]
    if (middle := _from_the_first(depths, NEAR_MIN_MM)) is not None:
        yield f"{gap} is a depth of {middle:.3g} mm from the first frame on, before anything touches: another zero?"
    with np.errstate(invalid="ignore"):
        pressed, away = -gap_mm >= CONTACT_MIN_DEPTH_MM, gap_mm > NEAR_MIN_MM
        at_odds = (pressed & (force_n <= felt_n)) | (away & (force_n > felt_n))
    touching = pressed | (force_n > felt_n)
    if at_odds.sum() > max(1, MOST_AT_ODDS * touching.sum()):
        yield (
            f"force_n and {gap} disagree in {int(at_odds.sum())} frames, which touch by one and not by the other: "
            "another zero, unit or clock?"
        )


def _from_the_first(values: Array, least: float) -> float | None:
    """The median of the first values, where they are all above the least and steady, or no later one falls below it."""
    first = values[:UNTARED_FRAMES]
    if len(first) < UNTARED_FRAMES or first.min() <= least:
        return None
    middle = float(np.median(first))
    return middle if values.min() > least or np.abs(first - middle).max() <= STEADY * middle else None
