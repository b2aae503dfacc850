"""When the rows of a frame see what they show."""

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.settings import Shutter

ROUNDING = 1e-9
"""Rounding of the products of times and rates."""


def row_ends_s(shutter: Shutter, *, rows: int, time_s: float) -> Array:
    """End of the exposure of each row, shape (rows,) [s]: the last one's is the frame's time."""
    return np.asarray(time_s - 1e-6 * shutter.row_us * np.arange(rows - 1, -1, -1))


def exposure_s(shutter: Shutter, frames_per_second: float) -> float:
    """How long a row collects light: never longer than from frame to frame [s]."""
    return min(shutter.exposure_ms / 1000, 1 / frames_per_second)


def between_frames(before: FloatImage, now: FloatImage, shutter: Shutter, *, frames_per_second: float) -> FloatImage:
    """What rows see of two states that follow each other, linear between them; shape (rows, columns, 3).

    Args:
        before: Radiance at the time of the frame before, shape (rows, columns, 3).
        now: Radiance at the time of this one.
        shutter: When the rows collect light.
        frames_per_second: Frame rate [1/s].
    """
    middle_s = row_ends_s(shutter, rows=len(now), time_s=0.0) - exposure_s(shutter, frames_per_second) / 2
    share = np.clip(1 + frames_per_second * middle_s, 0, 1)[:, None, None]
    return np.asarray(before + share * (now - before), np.float32)


def readout_fits(shutter: Shutter, *, rows: int, frames_per_second: float) -> bool:
    """Whether the rows are read before the next frame's are."""
    return 1e-6 * shutter.row_us * rows * frames_per_second <= 1 + ROUNDING


def readout_problem(shutter: Shutter, *, rows: int, frames_per_second: float) -> str:
    """What is wrong where they are not."""
    return (
        f"camera.shutter.row_us = {shutter.row_us:g} is not allowed: {rows} rows are read in "
        f"{1e-3 * shutter.row_us * rows:.3g} ms, which must be at most the {1000 / frames_per_second:.3g} ms between "
        "frames"
    )
