"""Temporal fusion: references of the untouched sensor from its first frames, its grid among them.

Published as the first algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382), with N = 30 frames,
M = 3 background references and tau_B = 35.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.detectors.profile import DetectorProfile, GridKind, Polarity
from magicsim.errors import FrameError

FULL = 255
"""Mask value of a pixel that shows the grid."""
PER_CENT = 100.0
"""Level of a pixel that is as bright as its surroundings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GridReference:
    """The untouched grid, from `fuse_grid` with the options of a profile."""

    counts: npt.NDArray[np.uint8]
    """Number of reference frames in which a pixel showed the grid, 0..frames, shape (rows, columns, 3); 0 or `frames`
    alone where the majority decides."""
    frames: int
    areas: tuple[float, float, float]
    """Sum of `counts` per channel; 0 where a channel never shows the grid."""
    tau_b: int
    polarity: Polarity
    blur_px: int
    blur_sigma_px: float
    kind: GridKind
    surround_px: int


def blur(image: Frame, size_px: int, sigma_px: float = 0.0) -> Frame:
    """Gaussian blur rounded to 8 bit; pixels beyond the edge mirror those inside, without repeating the edge.

    Each axis is weighed by k_i = exp(-i i / (2 sigma sigma)) / sum, i = -(size - 1) / 2 .. (size - 1) / 2; with
    OpenCV's own sigma, 0.15 `size_px` + 0.35, which `sigma_px` = 0 stands for, kernels of 3, 5 and 7 px are (1, 2, 1) /
    4, (1, 4, 6, 4, 1) / 16 and (2, 7, 14, 18, 14, 7, 2) / 64. Sides of 0 and 1 leave the image as it is.
    """
    if size_px <= 1:
        return image
    return np.asarray(cv2.GaussianBlur(image, (size_px, size_px), sigma_px), dtype=np.uint8)


def levelled(blurred: Frame, surround_px: int) -> Frame:
    """Brightness of each pixel in per cent of its surroundings', rounded to 8 bit; an image as it is for 0.

    What an approaching object does to the light as a whole, and a camera to its gain, falls out of it: walls stay
    darker than what lies between them. Surroundings are a Gaussian mean of standard deviation `surround_px`, mirrored
    at the edge; where they are black, all is. They are smooth, so that means of blocks of half a standard deviation
    give them for a quarter of the time, within 1 % of the mean over all pixels for a grid of thin walls, two standard
    deviations from the edge.
    """
    if surround_px == 0:
        return blurred
    values = blurred.astype(np.float32)
    rows, columns = values.shape[:2]
    side = max(1, surround_px // 2)
    blocks = cv2.resize(values, (-(-columns // side), -(-rows // side)), interpolation=cv2.INTER_AREA)
    mean = cv2.GaussianBlur(blocks, (0, 0), surround_px / side, borderType=cv2.BORDER_REFLECT)
    surroundings = cv2.resize(mean, (columns, rows), interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.divide(values, surroundings, scale=PER_CENT, dtype=cv2.CV_8U), dtype=np.uint8)


def grid_mask(blurred: Frame, *, tau_b: int, polarity: Polarity) -> npt.NDArray[np.uint8]:
    """Pixels that show the grid: `FULL` there and 0 elsewhere, per channel. Dark: F <= tau_b; bright: F > tau_b.

    The image, shape (rows, columns, 3), is one after `blur` and `levelled`; where it was levelled, tau_b is in per cent
    of the surroundings.
    """
    mode = cv2.THRESH_BINARY if polarity == "bright" else cv2.THRESH_BINARY_INV
    return np.asarray(cv2.threshold(blurred, tau_b, FULL, mode)[1], dtype=np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True)
class BackgroundReference:
    """How bright the untouched sensor is, from `fuse_background`."""

    images: npt.NDArray[np.uint8]
    """The M background references, each a mean rounded to 8 bit, shape (M, rows, columns, 3)."""
    ceiling: Frame
    """Largest of the M images at every pixel and channel, shape (rows, columns, 3)."""
    blur_px: int


def fuse_background(frames: Sequence[Frame], *, count: int, blur_px: int = 0) -> BackgroundReference:
    """Means of `count` runs of consecutive frames, rounded to 8 bit (halves up).

    B_j = (M / N) sum of F_i, i = (j - 1) N / M + 1 .. j N / M, per channel, j = 1..M; runs differ by one frame where M
    does not divide N. Frames have one shape (rows, columns, 3); there are at least `count`.
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


def fuse_grid(frames: Sequence[Frame], profile: DetectorProfile) -> GridReference:
    """Average of the binarised frames: G_ref = (1 / N) sum of b(blur(F_i)), per channel.

    b is 1 where `grid_mask` sees the grid. With `majority` G_ref is 1 where that average is above one half, else 0.
    There are 1 to 255 frames of one shape (rows, columns, 3).
    """
    tau_b, polarity = profile.tau_b, profile.polarity
    counts = np.zeros(frames[0].shape, dtype=np.uint8)
    for frame in frames:
        level = levelled(blur(frame, profile.grid_blur_px, profile.grid_blur_sigma_px), profile.surround_px)
        counts += grid_mask(level, tau_b=tau_b, polarity=polarity) // FULL
    if profile.grid_reference == "majority":
        counts = np.where(counts > len(frames) // 2, np.uint8(len(frames)), np.uint8(0))
    red, green, blue = cv2.sumElems(counts)[:3]
    if not red + green + blue:
        side = "at or below" if polarity == "dark" else "above"
        raise FrameError(
            f"reference frames show no grid: no pixel is {side} tau_b = {tau_b} (polarity '{polarity}') of the "
            "detector profile; fit one to this sensor (magicsim fit profile)"
        )
    return GridReference(
        counts=counts, frames=len(frames), areas=(red, green, blue), tau_b=tau_b, polarity=polarity,
        blur_px=profile.grid_blur_px, blur_sigma_px=profile.grid_blur_sigma_px, kind=profile.grid_reference,
        surround_px=profile.surround_px,
    )  # fmt: skip
