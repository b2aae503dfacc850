"""Mains light as rows of a rolling shutter see it.

Light 1 + m cos(2 pi f t + p) with f twice the mains frequency, averaged over an exposure of length T that ends at t, is
1 + m sinc(f T) cos(2 pi f (t - T / 2) + p), sinc(x) = sin(pi x) / (pi x).
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.effects.randomness import PHASE_STREAM, deviates
from magicsim.camera.settings import Flicker, Shutter
from magicsim.camera.shutter import exposure_s, row_ends_s


def flicker_share(
    flicker: Flicker, shutter: Shutter, *, rows: int, time_s: float, frames_per_second: float, seed: int
) -> Array:
    """By how much of its mean the room's light exceeds it in each row, shape (rows,).

    Args:
        flicker: Frequency and depth.
        shutter: When the rows collect light.
        rows: Of the whole image.
        time_s: Time of the frame [s].
        frames_per_second: Frame rate [1/s].
        seed: Of the episode, which begins somewhere in the swing.
    """
    frequency, open_s = 2 * flicker.mains_hz, exposure_s(shutter, frames_per_second)
    phase = 2 * np.pi * deviates(seed, PHASE_STREAM).random()
    middle = row_ends_s(shutter, rows=rows, time_s=time_s) - open_s / 2
    size = flicker.depth * np.sinc(frequency * open_s)
    return np.asarray(size * np.cos(2 * np.pi * frequency * middle + phase))
