"""Temporal fusion: references of the untouched sensor from its first frames.

Published as the first algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382), with N = 30 frames,
M = 3 background references and tau_B = 35.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.grid import FULL, GridReference, blur, grid_mask, levelled
from magicsim.detectors.profiles.profile import DetectorProfile, GridKind, Polarity
from magicsim.errors import FrameError


@dataclass(frozen=True, slots=True, kw_only=True)
class BackgroundReference:
    """How bright the untouched sensor is, from `fuse_background`."""

    images: npt.NDArray[np.uint8]
    """The M background references, each a mean rounded to 8 bit, shape (M, rows, columns, 3)."""
    ceiling: Frame
    """Largest of the M images at every pixel and channel, shape (rows, columns, 3)."""
    blur_px: int
    """Side of the Gaussian kernel before the difference [px]; 0 is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class References:
    """All that the detectors remember of the untouched sensor."""

    background: BackgroundReference
    grid: GridReference


def fuse(frames: Iterable[Frame], profile: DetectorProfile) -> References:
    """Build the references from frames of the untouched sensor, in their order in time.

    Takes the first `profile.reference_count` frames. Fewer are accepted as long as each background
    reference gets a frame; `References.grid.frames` tells how many there were.

    Raises:
        FrameError: Fewer frames than background references, a frame that is not an image, frames of
            different sizes, or no grid in any channel.
    """
    taken = list(islice(frames, profile.reference_count))
    if len(taken) < profile.background_count:
        msg = (
            f"{len(taken)} reference frame(s) are too few; must be at least background_count = "
            f"{profile.background_count}, better reference_count = {profile.reference_count}"
        )
        raise FrameError(msg)
    first = check_frame(taken[0])
    checked = [check_frame(frame, shape=first.shape) for frame in taken]
    return References(
        background=fuse_background(checked, count=profile.background_count, blur_px=profile.difference_blur_px),
        grid=fuse_grid(
            checked,
            tau_b=profile.tau_b,
            polarity=profile.polarity,
            blur_px=profile.grid_blur_px,
            blur_sigma_px=profile.grid_blur_sigma_px,
            kind=profile.grid_reference,
            surround_px=profile.surround_px,
        ),
    )


def fuse_background(frames: Sequence[Frame], *, count: int, blur_px: int = 0) -> BackgroundReference:
    """Means of `count` runs of consecutive frames, rounded to 8 bit (halves up).

    B_j = (M / N) sum of F_i, i = (j - 1) N / M + 1 .. j N / M, per channel, j = 1..M.

    Args:
        frames: Frames of one shape (rows, columns, 3), at least `count`.
        count: Number of background references M; runs differ by one frame where M does not divide N.
        blur_px: Side of the Gaussian kernel on each frame [px]; 0 is none.
    """
    edges = [index * len(frames) // count for index in range(count + 1)]
    images = np.stack(
        [_rounded_mean([blur(frame, blur_px) for frame in frames[start:stop]]) for start, stop in pairwise(edges)]
    )
    return BackgroundReference(images=images, ceiling=images.max(axis=0), blur_px=blur_px)


def _rounded_mean(frames: Sequence[Frame]) -> Frame:
    """Mean of frames in whole numbers, so that no rounding depends on the order of the sum."""
    total = np.zeros(frames[0].shape, dtype=np.uint32)
    for frame in frames:
        total += frame
    return ((2 * total + len(frames)) // (2 * len(frames))).astype(np.uint8)


def fuse_grid(
    frames: Sequence[Frame],
    *,
    tau_b: int,
    polarity: Polarity,
    blur_px: int,
    blur_sigma_px: float = 0.0,
    kind: GridKind = "presence",
    surround_px: int = 0,
) -> GridReference:
    """Average of the binarised frames: G_ref = (1 / N) sum of b(blur(F_i)), per channel.

    b is 1 where `grid_mask` sees the grid. With `majority` G_ref is 1 where that average is above one half, else 0.

    Args:
        frames: 1 to 255 frames of one shape (rows, columns, 3).
        tau_b: Grey level that separates grid from background.
        polarity: Side of `tau_b` that is the grid.
        blur_px: Side of the Gaussian kernel before binarising [px]; 0 is none.
        blur_sigma_px: Its standard deviation [px]; 0 takes OpenCV's for the side.
        kind: Whether the average itself is kept or what the majority of frames shows.
        surround_px: Standard deviation of the surroundings that a pixel is compared with [px]; 0 compares with `tau_b`.

    Raises:
        FrameError: No channel of any frame shows the grid; a similarity to nothing has no meaning.
    """
    counts = np.zeros(frames[0].shape, dtype=np.uint8)
    for frame in frames:
        level = levelled(blur(frame, blur_px, blur_sigma_px), surround_px)
        counts += grid_mask(level, tau_b=tau_b, polarity=polarity) // FULL
    if kind == "majority":
        counts = np.where(counts > len(frames) // 2, np.uint8(len(frames)), np.uint8(0))
    red, green, blue = cv2.sumElems(counts)[:3]
    if not red + green + blue:
        side = "at or below" if polarity == "dark" else "above"
        msg = (
            f"reference frames show no grid: no pixel is {side} tau_b = {tau_b} (polarity '{polarity}') of the "
            "detector profile; fit one to this sensor (magicsim calibrate)"
        )
        raise FrameError(msg)
    return GridReference(
        counts=counts,
        frames=len(frames),
        areas=(red, green, blue),
        tau_b=tau_b,
        polarity=polarity,
        blur_px=blur_px,
        blur_sigma_px=blur_sigma_px,
        kind=kind,
        surround_px=surround_px,
    )
