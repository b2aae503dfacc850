"""Adaptive Wiener filter: detail of an image is kept as far as it stands out of noise of known variance.

Local means stay. What is left of them is weighted by its share of signal in the local energy (Lee 1980,
doi:10.1109/TPAMI.1980.4766994), found twice: from the noisy detail, then from the detail that the first weights kept.
"""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

Array = npt.NDArray[np.float64]
SPREAD_PX = 1.5
"""Standard deviation of local means and energies [px]."""
REACH_PX = 3
"""Largest distance of a neighbour in one mean, along columns and rows [px]."""
MARGIN_PX = 3 * REACH_PX
"""How far around a pixel its filtered value looks [px]: detail, its energy, the energy of what is kept."""


def filtered(image: Array, variance: Array) -> Array:
    """The image with detail weighted down where it is not more than noise.

    Args:
        image: Shape (rows, columns, channels); the weights are the same for all channels.
        variance: Of the noise, summed over channels, shape (rows, columns, 1); 0 leaves a pixel as it is.

    Returns:
        Shape (rows, columns, channels).
    """
    mean = local_mean(image, SPREAD_PX, REACH_PX)
    detail = image - mean
    seen = _energy(detail)
    first = np.divide(seen - variance, seen, out=np.zeros_like(seen), where=seen > variance)
    signal = _energy(first * detail)
    found = signal + variance
    weight = np.divide(signal, found, out=np.ones_like(signal), where=variance > 0)
    return mean + weight * detail


def local_mean(image: Array, spread_px: float, reach_px: int) -> Array:
    """Gaussian mean over neighbouring pixels of each channel.

    Args:
        image: Shape (rows, columns, channels).
        spread_px: Standard deviation [px].
        reach_px: Largest distance of a neighbour along columns and rows [px].
    """
    return np.asarray(gaussian_filter(image, spread_px, mode="nearest", radius=reach_px, axes=(0, 1)))


def _energy(detail: Array) -> Array:
    """Local mean of the square, summed over channels, shape (rows, columns, 1)."""
    return local_mean((detail**2).sum(2, keepdims=True), SPREAD_PX, REACH_PX)
