"""Other strengths and colours of the lights without rendering again: a weighted sum of one image for each light."""

from collections.abc import Mapping

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.errors import ConfigError, unknown_choice

Rgb = tuple[float, float, float]


def relight(basis: Mapping[str, FloatImage], strengths: Mapping[str, float | Rgb]) -> FloatImage:
    """The image under changed lights.

    Args:
        basis: One linear radiance image for each light, shape (rows, columns, 3): `Renderer.basis`, or the arrays of
            `magicsim render --basis`.
        strengths: Radiance of a light in units of the one it was rendered with, alike or one a channel; lights that are
            not named keep theirs.

    Raises:
        ConfigError: A light that the basis does not have, or a strength that is negative or not finite.
    """
    for name, strength in strengths.items():
        if name not in basis:
            raise ConfigError(unknown_choice("light", name, basis))
        if not np.all(np.isfinite(strength)) or np.min(strength) < 0:
            raise ConfigError(f"strength of {name} = {strength} is not allowed: must be 0 or more, and finite")
    images = [np.multiply(image, strengths.get(name, 1.0), dtype=np.float32) for name, image in basis.items()]
    return np.asarray(np.sum(images, axis=0), np.float32)
