"""What of the untouched sensor's noise a frame shares with it, found from the images themselves.

Frames of an episode share their random numbers. Where nothing changed a frame has the very noise of the untouched
sensor's cheap image; where the grid is deformed its camera paths are others, and taking that noise off would add it.
"""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from magicsim.scenes.wiener import local_mean

FloatImage = npt.NDArray[np.float32]
Array = npt.NDArray[np.float64]
SPREAD_PX = 6.0
"""Standard deviation of the weights of neighbouring pixels [px]: half as much is noisier, more blurs what is local."""
REACH_PX = 12
"""Largest distance of a neighbour along columns and rows [px]."""
NOISE_SPREAD_PX = 3.0
"""Standard deviation of the mean of squared noise [px]."""
NOISE_REACH_PX = 6


def change_and_noise(now: FloatImage, cheap: FloatImage, careful: FloatImage) -> tuple[Array, Array]:
    """How a frame differs from the untouched sensor, less the noise that both share, and how noisy that still is.

    The share is the linear regression of the frame on that noise over the channels of all neighbours. A pixel's own
    values are left out, so that its own noise does not choose its share: the mean stays as it is (a control variate
    with a coefficient that is independent of what it multiplies). Every pixel sums in one order: crops are exact.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        cheap: The untouched sensor with the frame's random numbers and samples, of the same shape.
        careful: The untouched sensor with many samples, of the same shape.

    Returns:
        The change, shape (rows, columns, 3), and the variance of its noise, summed over the channels, shape (rows,
        columns, 1). That takes a frame to be as noisy as the untouched sensor for the light that it gets, never more.
    """
    noise = cheap.astype(np.float64) - careful
    changed = now.astype(np.float64) - careful
    shared, squared = _of_neighbours(changed * noise), _of_neighbours(noise**2)
    share = np.clip(np.divide(shared, squared, out=np.zeros_like(shared), where=squared > 0), 0, 1)
    variance = local_mean((noise**2).sum(2, keepdims=True), NOISE_SPREAD_PX, NOISE_REACH_PX)
    before, after = (
        local_mean(image.sum(2, keepdims=True, dtype=np.float64), NOISE_SPREAD_PX, NOISE_REACH_PX)
        for image in (careful, now)
    )
    level = np.clip(np.divide(after, before, out=np.zeros_like(after), where=before > 0), 0, 1)
    return changed - share * noise, variance * np.maximum(level**2 - share**2, 0)


def _of_neighbours(values: Array) -> Array:
    """Weighted sum over channels and pixels around each, without itself, shape (rows, columns, 1)."""
    flat = values.sum(2)
    around = gaussian_filter(flat, SPREAD_PX, mode="nearest", radius=REACH_PX)
    return np.asarray(around - _own_weight() * flat)[:, :, None]


def _own_weight() -> float:
    pulse = np.zeros(2 * REACH_PX + 1)
    pulse[REACH_PX] = 1
    return float(gaussian_filter1d(pulse, SPREAD_PX, mode="nearest", radius=REACH_PX)[REACH_PX]) ** 2
