"""Which pixels of an image show the grid, and how often the untouched sensor shows it there."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.detectors.profiles.profile import GridKind, Polarity

FULL = 255
"""Mask value of a pixel that shows the grid."""
PER_CENT = 100.0
"""Level of a pixel that is as bright as its surroundings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GridReference:
    """What the untouched grid looks like, from `fuse_grid`."""

    counts: npt.NDArray[np.uint8]
    """Number of reference frames in which a pixel showed the grid, 0..frames, shape (rows, columns, 3); 0 or `frames`
    alone where the majority decides."""
    frames: int
    """Number of reference frames, 1..255."""
    areas: tuple[float, float, float]
    """Sum of `counts` per channel; 0 where a channel never shows the grid."""
    tau_b: int
    """Grey level that separates grid from background."""
    polarity: Polarity
    """Side of `tau_b` that is the grid."""
    blur_px: int
    """Side of the Gaussian kernel before binarising [px]; 0 is none."""
    blur_sigma_px: float = 0.0
    """Its standard deviation [px]; 0 takes OpenCV's for the side."""
    kind: GridKind = "presence"
    """What was kept of the binarised frames."""
    surround_px: int = 0
    """Standard deviation of the surroundings that a pixel is compared with [px]; 0 compares with `tau_b`."""


def blur(image: Frame, size_px: int, sigma_px: float = 0.0) -> Frame:
    """Gaussian blur rounded to 8 bit; pixels beyond the edge mirror those inside, without repeating the edge.

    Each axis is weighed by k_i = exp(-i i / (2 sigma sigma)) / sum, i = -(size - 1) / 2 .. (size - 1) / 2; with
    OpenCV's own sigma, kernels of 3, 5 and 7 px are (1, 2, 1) / 4, (1, 4, 6, 4, 1) / 16 and
    (2, 7, 14, 18, 14, 7, 2) / 64.

    Args:
        image: Shape (rows, columns, 3).
        size_px: Side of the kernel [px], odd. 0 and 1 leave the image as it is.
        sigma_px: Standard deviation [px]; 0 takes OpenCV's 0.15 `size_px` + 0.35.
    """
    if size_px <= 1:
        return image
    return np.asarray(cv2.GaussianBlur(image, (size_px, size_px), sigma_px), dtype=np.uint8)


def levelled(blurred: Frame, surround_px: int) -> Frame:
    """Brightness of each pixel in per cent of its surroundings', rounded to 8 bit; an image as it is for 0.

    What an approaching object does to the light as a whole, and a camera to its gain, falls out of it: walls stay
    darker than what lies between them. Surroundings are a Gaussian mean, mirrored at the edge; where they are black,
    all is. They are smooth, so that means of blocks of half a standard deviation give them for a quarter of the time,
    within 1 % of the mean over all pixels for a grid of thin walls, two standard deviations from the edge.

    Args:
        blurred: Image after `blur`, shape (rows, columns, 3).
        surround_px: Standard deviation of the mean [px].
    """
    if surround_px == 0:
        return blurred
    values = blurred.astype(np.float32)
    surroundings = _surroundings(values, surround_px)
    return np.asarray(cv2.divide(values, surroundings, scale=PER_CENT, dtype=cv2.CV_8U), dtype=np.uint8)


def _surroundings(values: npt.NDArray[np.float32], surround_px: int) -> npt.NDArray[np.float32]:
    """Gaussian mean around each pixel, from means of blocks [grey levels]."""
    rows, columns = values.shape[:2]
    side = max(1, surround_px // 2)
    blocks = cv2.resize(values, (-(-columns // side), -(-rows // side)), interpolation=cv2.INTER_AREA)
    mean = cv2.GaussianBlur(blocks, (0, 0), surround_px / side, borderType=cv2.BORDER_REFLECT)
    return np.asarray(cv2.resize(mean, (columns, rows), interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def grid_mask(blurred: Frame, *, tau_b: int, polarity: Polarity) -> npt.NDArray[np.uint8]:
    """Pixels that show the grid: `FULL` there and 0 elsewhere, per channel.

    Dark grid: F <= tau_b. Bright grid: F > tau_b.

    Args:
        blurred: Image after `blur` and `levelled`, shape (rows, columns, 3).
        tau_b: Grey level, or per cent of the surroundings' where the image was levelled; a pixel above it is bright,
            one at or below it is dark.
        polarity: Whether dark or bright pixels are the grid.
    """
    mode = cv2.THRESH_BINARY if polarity == "bright" else cv2.THRESH_BINARY_INV
    return np.asarray(cv2.threshold(blurred, tau_b, FULL, mode)[1], dtype=np.uint8)
