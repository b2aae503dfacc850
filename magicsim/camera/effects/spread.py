"""Diffraction and veiling glare: what spreads the light of a point by a known transfer of each spatial frequency.

Applied to the cosine transform of the image, whose mirror goes on beyond the border: all light stays in the image, and
what is sharper than pixels can show rings about its mean. A circular aperture transfers of a wave of frequency v
(2 / pi) (acos(u) - u sqrt(1 - u^2)) with u = v lambda N (Goodman, *Introduction to Fourier Optics*, section 6.3), a
Gaussian of deviation s exp(-2 pi^2 s^2 v^2).
"""

import numpy as np
from scipy.fft import dctn, idctn

from magicsim.arrays import Array, FloatImage
from magicsim.camera.settings import Diffraction, Glare


def spread_light(image: FloatImage, diffraction: Diffraction | None, glare: Glare | None) -> FloatImage:
    """The image as diffraction and glare spread it, shape (rows, columns, 3).

    Args:
        image: Linear radiance, shape (rows, columns, 3).
        diffraction: None where there is none.
        glare: None where there is none.
    """
    if diffraction is None and glare is None:
        return image
    frequency = frequencies(image.shape[0], image.shape[1])
    transfer = np.ones((*frequency.shape, 3))
    if diffraction is not None:
        waves = np.array(diffraction.wavelengths_nm)
        transfer *= aperture_transfer(
            frequency[..., None] * waves * diffraction.f_number / (1e3 * diffraction.pixel_um)
        )
    if glare is not None:
        veil = np.exp(-2 * (np.pi * glare.radius_px * frequency) ** 2)
        transfer *= (1 - glare.share + glare.share * veil)[..., None]
    waves = dctn(np.asarray(image, np.float64), axes=(0, 1))
    return np.asarray(idctn(waves * transfer, axes=(0, 1)), np.float32)


def frequencies(rows: int, columns: int) -> Array:
    """Spatial frequency of each wave of the cosine transform, shape (rows, columns) [cycles/px]."""
    down, across = np.arange(rows) / (2 * rows), np.arange(columns) / (2 * columns)
    return np.asarray(np.hypot(down[:, None], across))


def aperture_transfer(relative: Array) -> Array:
    """Transfer of a circular aperture without aberration.

    Args:
        relative: Spatial frequency times wavelength times f-number, 1 at the limit.
    """
    inside = np.clip(relative, 0, 1)
    return np.asarray(2 / np.pi * (np.arccos(inside) - inside * np.sqrt(1 - inside**2)))
