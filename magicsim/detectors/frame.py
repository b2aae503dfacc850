"""The one kind of image that the detectors take: 8-bit RGB."""

import numpy as np
import numpy.typing as npt

from magicsim.conventions import CHANNELS, MAX_PIXELS
from magicsim.errors import FrameError

Frame = npt.NDArray[np.uint8]
"""RGB image of grey levels 0..255, shape (rows, columns, 3)."""


def check_frame(frame: npt.ArrayLike, *, shape: tuple[int, ...] | None = None) -> Frame:
    """An RGB image as a contiguous frame, of a shape where one is given; a `FrameError` says why it cannot be one."""
    array = np.asarray(frame)
    if array.ndim != len(("rows", "columns", "channels")) or array.shape[2] != len(CHANNELS):
        raise FrameError(f"frame has shape {array.shape}; must be (rows, columns, 3) in RGB order")
    if array.size == 0:
        raise FrameError(f"frame has shape {array.shape}, no pixels; must have at least one row and one column")
    if array.dtype != np.uint8:
        raise FrameError(_wrong_type(array))
    if shape is not None and array.shape != shape:
        raise FrameError(f"frame has shape {array.shape}; must be {shape} like the reference")
    return np.ascontiguousarray(array, dtype=np.uint8)


def check_pixels(what: str, columns: int, rows: int) -> None:
    """Raise a FrameError where a picture has more than `MAX_PIXELS`; `what` is its kind and name."""
    if columns * rows > MAX_PIXELS:
        raise FrameError(f"{what} has {columns} x {rows} pixels; at most {MAX_PIXELS / 1e6:.0f} million are allowed")


def _wrong_type(array: npt.NDArray[np.generic]) -> str:
    """The line for an image that is not uint8, which also tells whether its values are numbers at all."""
    if np.issubdtype(array.dtype, np.inexact):
        bad = int(np.count_nonzero(~np.isfinite(array)))
        if bad:
            return f"frame has {bad} NaN or infinite values ({array.dtype}); must be uint8 grey levels 0..255"
    return f"frame has type {array.dtype}; must be uint8 grey levels 0..255"
