"""What colours of a frame say of a touch: evenness, disparity of the channels, brightening by side."""

import cv2
import numpy as np

from magicsim.arrays import Frame, Mask

CHANNELS = ("red", "green", "blue")
SIDES = ("-x", "+x", "-y", "+y")
BORDER = 0.08
"""Part of each side of the image, beside the strips, that evenness leaves out."""
WIDE_PX = 240
"""Columns of the image to which the next two belong; they follow the image's size."""
SMOOTH_PX = 10.5
"""Width of a cell, over which evenness does not look [px]."""
AROUND_PX = 15
"""How far around the contact the cells belong to it [px]."""


def around(mask: Mask) -> Mask:
    """A contact and the cells about it."""
    size = 2 * round(AROUND_PX * mask.shape[1] / WIDE_PX) + 1
    return cv2.dilate(mask.astype(np.uint8), np.ones((size, size), np.uint8)) > 0


def unevenness(image: Frame) -> list[float]:
    """Standard deviation over mean of each channel over the image, cells smoothed away; shape (3,)."""
    rows, columns, _ = image.shape
    smooth = cv2.GaussianBlur(image.astype(float), (0, 0), SMOOTH_PX * columns / WIDE_PX)
    inner = smooth[round(BORDER * rows) : -round(BORDER * rows), round(BORDER * columns) : -round(BORDER * columns)]
    return [float(inner[..., each].std() / inner[..., each].mean()) for each in range(3)]


def disparity(image: Frame, where: Mask) -> float:
    """Standard deviation across the channels of a pixel over their mean, averaged over pixels."""
    pixels = image[where].astype(float)
    return float((pixels.std(axis=1) / np.maximum(pixels.mean(axis=1), 1)).mean())


def brightening(rest: Frame, touched: Frame, where: Mask) -> dict[str, dict[str, float]]:
    """Mean change of each channel around a contact on its four sides [grey levels], by channel and side."""
    rows, columns = np.nonzero(where)
    y, x = np.mgrid[: where.shape[0], : where.shape[1]]
    dx, dy = x - columns.mean(), rows.mean() - y
    sides = dict(zip(SIDES, (-dx > abs(dy), dx > abs(dy), -dy > abs(dx), dy > abs(dx)), strict=True))
    change = touched.astype(float) - rest
    return {
        name: {side: float(change[where & part, each].mean()) for side, part in sides.items()}
        for each, name in enumerate(CHANNELS)
    }


def share_brighter(rest: Frame, touched: Frame, where: Mask) -> float:
    """Share of the pixels whose channels' sum rises."""
    return float((touched.astype(int).sum(2) > rest.astype(int).sum(2))[where].mean())
