"""From magicsim's frames (RGB, row 0 at +y, column 0 at -x) to what camera code expects."""

import numpy as np

from magicsim.arrays import Frame


def as_bgr(rgb: Frame) -> Frame:
    """A picture with its channels in OpenCV's order, in memory of its own, shape (rows, columns, 3)."""
    return np.ascontiguousarray(rgb[..., ::-1])


def as_landscape(portrait: Frame) -> Frame:
    """The picture turned clockwise by 90 degrees: row 0 at -x, column 0 at -y; shape (columns, rows, 3)."""
    return np.ascontiguousarray(np.rot90(portrait, -1))
