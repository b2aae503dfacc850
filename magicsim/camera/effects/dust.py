"""Specks of dust on the window, far out of focus: what part of the light they let through."""

import numpy as np

from magicsim.arrays import Array
from magicsim.camera.effects.randomness import DUST, PATTERN_STREAM, deviates
from magicsim.camera.settings import Dust

SPREAD = 0.5
"""Standard deviation of the logarithm of the radii; assumed."""


def transmittance(dust: Dust, *, rows: int, columns: int, pattern_seed: int) -> Array:
    """Part of the light that passes to each pixel, shape (rows, columns).

    A speck of radius r and opacity a takes a exp(-2 d^2 / r^2) at a distance d from its middle; a pi r^2 / 2 pixels in
    all.

    Args:
        dust: Number, size and opacity.
        rows: Of the whole image.
        columns: Of the whole image.
        pattern_seed: Of the camera.
    """
    random = deviates(pattern_seed, PATTERN_STREAM, DUST)
    places = random.random((dust.specks, 2)) * (rows, columns) - 0.5
    radii = dust.radius_px * np.exp(SPREAD * random.standard_normal(dust.specks))
    taken = dust.opacity * random.random(dust.specks)
    passes = np.ones((rows, columns))
    down, across = np.arange(rows), np.arange(columns)
    for (row, column), radius, opacity in zip(places, radii, taken, strict=True):
        along = np.exp(-2 * ((down - row) / radius) ** 2)
        passes *= 1 - opacity * along[:, None] * np.exp(-2 * ((across - column) / radius) ** 2)
    return passes
