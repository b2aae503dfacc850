"""Copies of arrays whose memory starts where vectors may be read.

The renderer takes an array over where it lies, and compiles a kernel anew for each alignment that it meets, which takes
longer than most frames.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

BYTES = 64
"""As long as the longest vector registers."""


def aligned(values: npt.NDArray[Any], kind: npt.DTypeLike) -> npt.NDArray[Any]:
    """A contiguous copy of the same shape, its elements of a kind."""
    source = np.asarray(values)
    room = np.empty(source.size * np.dtype(kind).itemsize + BYTES, np.uint8)
    start = -room.ctypes.data % BYTES
    copy = room[start : start + source.size * np.dtype(kind).itemsize].view(kind).reshape(source.shape)
    copy[...] = source
    return copy


def columns(values: npt.NDArray[Any]) -> list[npt.NDArray[np.float32]]:
    """Each column of a matrix as such a copy, shape (rows,)."""
    return [aligned(column, np.float32) for column in values.T]
