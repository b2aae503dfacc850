"""References that are none: the one question that whatever learns from an untouched sensor asks its frames."""

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from magicsim.detectors.combined import detect_all
from magicsim.detectors.frame import Frame
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import FrameError

MOST_RATIO = 1.1
"""Brightness of one channel over that of the others that is told."""
MOST_DRIFT = 0.03
"""Difference of a reference's brightness from the usual one that is told."""
LEAST_MEAN = 10.0
"""Mean grey level below which a frame is black."""


def told_of_references(untouched: Sequence[Frame], said: Sequence[tuple[str, str]]) -> Iterator[str]:
    """One line for each way in which frames are no references: black, coloured, drifting, or not untouched.

    Args:
        untouched: Frames that should show the untouched sensor, each (rows, columns, 3).
        said: Verdicts on proximity and, with everything known taken into account, on contact of each, see `said_of`;
            none where nobody judges them.
    """
    yield from _told_of_looks(untouched)
    odd = [number for number, each in enumerate(said) if each != (Proximity.NORMAL, Contact.UNTOUCHED)]
    if odd:
        yield (
            f"{len(odd)} of {len(said)} reference frames do not look untouched beside the others, the first of them "
            f"frame {odd[0]} ({', '.join(said[odd[0]])}); references are frames of the untouched sensor"
        )


def said_of(untouched: Sequence[Frame], profile: DetectorProfile | None = None) -> list[tuple[str, str]]:
    """Verdicts of a profile, by default the published one, on references against each other.

    None where there are too few of them, or the profile sees no grid there.
    """
    chosen = profile or load_profile("published")
    try:
        verdicts = detect_all(untouched, fuse(untouched, chosen), chosen)
    except FrameError:
        return []
    return [(each.proximity, each.combined) for each in verdicts]


def _told_of_looks(untouched: Sequence[Frame]) -> Iterator[str]:
    means = np.array([each.mean((0, 1)) for each in untouched]) + 1
    if not len(means):
        return
    black = black_frames(means, means[np.argmax(means.sum(1))])
    if black:
        yield f"reference frames {_numbers(black)} are black: leave out what a camera gives before it is ready"
    lit = [number for number in range(len(means)) if number not in black]
    if not lit:
        return
    shares = means[lit] / np.median(means[lit], 0)
    levels = np.median(shares, 1)
    tints = (shares.max(1) / shares.min(1)) > MOST_RATIO
    if coloured := [number for number, is_tinted in zip(lit, tints, strict=True) if is_tinted]:
        yield f"reference frames {_numbers(coloured)} have other colours than the rest: lock the white balance"
    drifting = [
        number
        for number, level, is_tinted in zip(lit, levels, tints, strict=True)
        if abs(level - 1) > MOST_DRIFT and not is_tinted
    ]
    if drifting:
        span = f"{100 * levels.min():.0f} to {100 * levels.max():.0f} %"
        yield (
            f"references drift, with {span} of their usual brightness (frames {_numbers(drifting)}): lock the "
            "exposure, and leave out the first frames"
        )


def black_frames(means: npt.NDArray[np.float64], usual: npt.NDArray[np.float64]) -> list[int]:
    """Numbers of frames that are black beside a usual one, by mean grey levels of shape (frames, 3)."""
    return np.flatnonzero(means.mean(1) < min(LEAST_MEAN, usual.mean() / 2)).tolist()


def _numbers(numbers: Sequence[int]) -> str:
    """Numbers as a text, the first three and how many there are."""
    shown = ", ".join(map(str, numbers[:3]))
    return shown if len(numbers) <= 3 else f"{shown} and {len(numbers) - 3} more"  # noqa: PLR2004
