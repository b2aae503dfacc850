"""Pixels and rows that differ: dark signals, hot and dead pixels, offsets of rows."""

from functools import lru_cache

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.camera.effects.randomness import DARK, DEAD, HOT, PATTERN_STREAM, ROWS, deviates
from magicsim.camera.settings import PixelFaults


@lru_cache(maxsize=4)
def dark_signal_e(faults: PixelFaults, *, rows: int, columns: int, pattern_seed: int) -> Array:
    """Dark signal of each pixel about the mean that the driver takes off, shape (rows, columns, 3) [electrons]."""
    shape = (rows, columns, 3)
    dark = faults.dark_e * deviates(pattern_seed, PATTERN_STREAM, DARK).standard_normal(shape)
    random = deviates(pattern_seed, PATTERN_STREAM, HOT)
    is_hot = random.random(shape) < faults.hot_share
    return np.asarray(dark + is_hot * faults.hot_e * random.standard_exponential(shape))


@lru_cache(maxsize=4)
def is_alive(faults: PixelFaults, *, rows: int, columns: int, pattern_seed: int) -> Mask:
    """Which pixels see light, shape (rows, columns, 3)."""
    return np.asarray(deviates(pattern_seed, PATTERN_STREAM, DEAD).random((rows, columns, 3)) >= faults.dead_share)


def row_offsets_e(faults: PixelFaults, *, rows: int, seed: int, frame: int) -> Array:
    """Offset of each row in a frame, shape (rows, 1, 1) [electrons]."""
    return np.asarray(faults.row_e * deviates(seed, frame, ROWS).standard_normal((rows, 1, 1)))
