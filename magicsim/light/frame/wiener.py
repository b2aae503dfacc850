"""Adaptive Wiener filter: detail of an image is kept as far as it stands out of noise of known variance.

Local means stay. What is left of them is weighted by its share of signal in the local energy (Lee 1980,
doi:10.1109/TPAMI.1980.4766994), found twice: from the noisy detail, then from the detail that the first weights kept.
One weight serves all channels, each of which counts in units of its own noise.
"""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

Array = npt.NDArray[np.float64]
SPREAD_PX = 1.5
"""Standard deviation of local means [px]."""
MEAN_REACH_PX = 3
"""Largest distance of a neighbour in one mean, along columns and rows [px]."""
ENERGY_SPREAD_PX = 2.5
"""Standard deviation of the mean of squared detail [px]: over fewer pixels noise passes that happens to be strong, over
more of them detail is lost that is local."""
ENERGY_REACH_PX = 5
"""The same as of a local mean."""
REACH_PX = MEAN_REACH_PX + 2 * ENERGY_REACH_PX
"""How far around a pixel its filtered value looks [px]: detail, its energy, the energy of what is kept."""


def filtered(image: Array, variance: Array) -> Array:
    """The image with detail weighted down where it is not more than noise.

    Args:
        image: Shape (rows, columns, channels).
        variance: Of the noise in the image's detail, of the same shape; a value of 0 leaves a channel as it is.

    Returns:
        Of the same shape.
    """
    fine = detail(image)
    is_noisy = variance > 0
    units = np.divide(fine, np.sqrt(variance), out=np.zeros_like(fine), where=is_noisy)
    noise = is_noisy.sum(2, keepdims=True)
    seen = _energy(units)
    first = np.divide(seen - noise, seen, out=np.zeros_like(seen), where=seen > noise)
    signal = _energy(first * units)
    weight = np.divide(signal, signal + noise, out=np.ones_like(signal), where=noise > 0)
    return np.where(is_noisy, image - (1 - weight) * fine, image)


def detail(image: Array) -> Array:
    """What an image differs by from its local means, shape (rows, columns, channels)."""
    return image - local_mean(image, SPREAD_PX, MEAN_REACH_PX)


def local_mean(image: Array, spread_px: float, reach_px: int) -> Array:
    """Gaussian mean over neighbouring pixels of each channel.

    Args:
        image: Shape (rows, columns, channels).
        spread_px: Standard deviation [px].
        reach_px: Largest distance of a neighbour along columns and rows [px].
    """
    return np.asarray(gaussian_filter(image, spread_px, mode="nearest", radius=reach_px, axes=(0, 1)))


def _energy(fine: Array) -> Array:
    """Local mean of the square, summed over channels, shape (rows, columns, 1)."""
    return local_mean((fine**2).sum(2, keepdims=True), ENERGY_SPREAD_PX, ENERGY_REACH_PX)
