"""Slow random wander with a correlation that falls as exp(-t / T), known at any time without those before.

A sum of cosines whose frequencies follow the spectrum (a Cauchy distribution of width 1 / T) has that correlation
(Shinozuka and Deodatis, *Appl. Mech. Rev.* 44, 191, 1991).
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.effects.randomness import DRIFT_STREAM, deviates
from magicsim.camera.settings import LedDrift

WAVES = 64
"""Cosines in the sum."""


def led_drift(drift: LedDrift, *, time_s: float, seed: int) -> Array:
    """Relative change of the LEDs' red, green and blue, shape (3,).

    Args:
        drift: Its size and slowness.
        time_s: Since the stream began [s].
        seed: Of the episode.
    """
    random = deviates(seed, DRIFT_STREAM)
    frequency = random.standard_cauchy((WAVES, 3)) / drift.time_s
    phase = 2 * np.pi * random.random((WAVES, 3))
    return np.asarray(drift.share * np.sqrt(2 / WAVES) * np.cos(frequency * time_s + phase).sum(0))
