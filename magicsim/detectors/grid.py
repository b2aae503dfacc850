"""Which pixels of an image show the grid, and how often the untouched sensor shows it there."""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.detectors.frame import Frame
from magicsim.detectors.profile import Polarity

FULL = 255
"""Mask value of a pixel that shows the grid."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GridReference:
    """What the untouched grid looks like, from `fuse_grid`."""

    counts: npt.NDArray[np.uint8]
    """Number of reference frames in which a pixel showed the grid, 0..frames, shape (rows, columns, 3)."""
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

    @property
    def presence(self) -> npt.NDArray[np.float64]:
        """Share of reference frames in which a pixel showed the grid, 0..1, shape (rows, columns, 3)."""
        return self.counts / float(self.frames)


def blur(image: Frame, size_px: int) -> Frame:
    """Gaussian blur rounded to 8 bit.

    Args:
        image: Shape (rows, columns, 3).
        size_px: Side of the kernel [px], odd; its standard deviation is OpenCV's 0.15 `size_px` + 0.35.
            0 and 1 leave the image as it is.
    """
    if size_px <= 1:
        return image
    return np.asarray(cv2.GaussianBlur(image, (size_px, size_px), 0), dtype=np.uint8)


def grid_mask(blurred: Frame, *, tau_b: int, polarity: Polarity) -> npt.NDArray[np.uint8]:
    """Pixels that show the grid: `FULL` there and 0 elsewhere, per channel.

    Args:
        blurred: Image after `blur`, shape (rows, columns, 3).
        tau_b: Grey level; a pixel above it is bright, one at or below it is dark.
        polarity: Whether dark or bright pixels are the grid.
    """
    mode = cv2.THRESH_BINARY if polarity == "bright" else cv2.THRESH_BINARY_INV
    return np.asarray(cv2.threshold(blurred, tau_b, FULL, mode)[1], dtype=np.uint8)
