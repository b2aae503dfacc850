"""Which way up frames are beside others of the same sensor: turned, mirrored, with red and blue exchanged."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[Any]
Turn = tuple[int, bool]
"""Counter-clockwise turn [degrees], and whether left and right are exchanged after it."""
TURNS: tuple[Turn, ...] = tuple(product((0, 90, 180, 270), (False, True)))
"""Every orientation of a rectangle; the first changes nothing."""
Change = tuple[Turn, bool]
"""A turn, and whether red and blue are exchanged."""
COMPARED_PX = 48
"""Longer side of the pictures that are compared [px]."""
LEAST_LIKENESS, LEAST_GAIN, ALIKE = 0.3, 0.1, 0.05
"""Correlation that another orientation must have, by how much it must be better, and by how much less others are no
worse."""


def turned(image: Pixels, turn: Turn) -> Pixels:
    """An image of shape (rows, columns, ...) turned and, after that, mirrored."""
    pixels = np.rot90(image, turn[0] // 90)
    return pixels[:, ::-1] if turn[1] else pixels


def after(first: Turn, then: Turn) -> Turn:
    """The one turn that does what two do one after the other."""
    mark = np.arange(6).reshape(2, 3)
    wanted = turned(turned(mark, first), then)
    return next(each for each in TURNS if np.array_equal(turned(mark, each), wanted))


def better_changes(images: Sequence[Pixels], other: Pixels) -> list[Change]:
    """Changes with which images are much more like another one of any size, the best first; none where they fit."""
    scored = {
        (turn, exchanged): float(
            np.mean([_correlation(turned(each[..., ::-1] if exchanged else each, turn), other) for each in images])
        )
        for turn in TURNS
        for exchanged in (False, True)
    }
    best = max(scored.values())
    if best < LEAST_LIKENESS or best < scored[TURNS[0], False] + LEAST_GAIN:
        return []
    return sorted((each for each in scored if scored[each] > best - ALIKE), key=lambda each: -scored[each])


def turned_against(references: Pixels, frames: Sequence[Pixels]) -> str | None:
    """One line where frames are turned against the references of their own sensor; None where they are not."""
    found = better_changes(frames, references)
    if not found:
        return None
    ways = []
    for (degrees, mirrored), exchanged in found:
        words = {
            f"turned by {degrees} degrees": degrees,
            "mirrored": mirrored,
            "with red and blue exchanged": exchanged,
        }
        ways.append(", ".join(word for word, is_so in words.items() if is_so) or "as they are")
    return f"frames look like their references only when they are {' or '.join(ways)}: record or save both alike"


def _correlation(image: Pixels, other: Pixels) -> float:
    """Pearson's coefficient of two colour images, reduced to the size of a thumbnail, all channels together."""
    rows, columns = other.shape[:2]
    scale = COMPARED_PX / max(rows, columns)
    size = (max(4, round(columns * scale)), max(4, round(rows * scale)))
    small = [
        cv2.resize(np.ascontiguousarray(each, np.float32), size, interpolation=cv2.INTER_AREA)
        for each in (image, other)
    ]
    one, two = (each.ravel() - each.mean() for each in small)
    norm = float(np.linalg.norm(one) * np.linalg.norm(two))
    return float(one @ two) / norm if norm else 0.0
