"""Image of a frame, anchored to the untouched sensor: the anchor's image and what the frame changes.

Frames of an episode share their random numbers. Where nothing changed a frame has the very noise of the untouched
sensor's control image; where the grid is deformed its camera paths are others, and taking that noise off would add it.
So the share of the noise that both have is found from the images themselves.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from magicsim.arrays import Array, FloatImage, Mask
from magicsim.camera.camera import Window

SPREAD_PX = 6.0
"""Standard deviation of the weights of neighbouring pixels [px]: half as much is noisier, more blurs what is local."""
REACH_PX = 12
"""Largest distance of a neighbour along columns and rows [px]."""


def anchored_image(now: FloatImage, control: FloatImage, anchor: FloatImage, changed: Mask) -> FloatImage:
    """The anchor's image and the change that a frame shows, less shared noise.

    Nothing smooths it: detail keeps its contrast (`benchmarks/detail.py`), and noise that is the frame's own stays.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        control: The untouched sensor with the frame's random numbers and samples, of the same shape.
        anchor: The untouched sensor with many samples, of the same shape.
        changed: Which pixels the frame can change, shape (rows, columns); the others are the anchor ones.
    """
    change = anchored_change(now, control, anchor, changed)
    return np.where(changed[..., None], np.maximum(change, 0), change)


def anchored_change(now: FloatImage, control: FloatImage, anchor: FloatImage, changed: Mask) -> FloatImage:
    """`anchored_image` of values that may be negative, as those are that one light changes."""
    result = anchor.copy()
    if not changed.any():
        return result
    rows, columns = (np.flatnonzero(changed.any(axis)) for axis in (1, 0))
    box = Window(
        column=int(columns[0]), row=int(rows[0]), columns=int(np.ptp(columns)) + 1, rows=int(np.ptp(rows)) + 1
    ).grown(REACH_PX, changed.shape[1], changed.shape[0])
    change = change_without_shared_noise(*(box.of(each) for each in (now, control, anchor)))
    box.of(result)[...] = np.where(box.of(changed)[..., None], box.of(anchor) + change, box.of(anchor))
    return result


def change_without_shared_noise(now: FloatImage, control: FloatImage, anchor: FloatImage) -> Array:
    """How a frame differs from the untouched sensor, less the noise that both share, shape (rows, columns, 3).

    The share is the linear regression of the frame on that noise over all neighbours, with a constant for each channel.
    A pixel's own values are left out, so that its own noise does not choose its share: the mean stays as it is (a
    control variate with a coefficient that is independent of what it multiplies). Up to six pixels from the border the
    mirror brings them back with a weight of 1 % at most. Every pixel sums in one order: crops are exact.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        control: The untouched sensor with the frame's random numbers and samples, of the same shape.
        anchor: The untouched sensor with many samples, of the same shape.
    """
    noise = control.astype(np.float64) - anchor
    changed = now.astype(np.float64) - anchor
    around_changed, around_noise = _of_neighbours(changed), _of_neighbours(noise)
    # Over all channels together: the mean over neighbours of a sum is the sum of their means.
    shared = _of_neighbours(_summed(changed * noise)) - _summed(around_changed * around_noise)
    squared = _of_neighbours(_summed(noise**2)) - _summed(around_noise**2)
    share = np.clip(np.divide(shared, squared, out=np.zeros_like(shared), where=squared > 0), 0, 1)
    return np.asarray(changed - share * noise)


def _summed(values: Array) -> Array:
    """Over the channels, shape (rows, columns, 1)."""
    return np.asarray(values.sum(2, keepdims=True))


def _of_neighbours(values: Array) -> Array:
    """Weighted mean over the pixels around each, without itself, in every channel."""
    own = _own_weight()
    # Mirrored at the border, which the mean then does not count again.
    around = gaussian_filter(values, SPREAD_PX, mode="mirror", radius=REACH_PX, axes=(0, 1))
    return np.asarray((around - own * values) / (1 - own))


def _own_weight() -> float:
    pulse = np.zeros(2 * REACH_PX + 1)
    pulse[REACH_PX] = 1
    return float(gaussian_filter1d(pulse, SPREAD_PX, radius=REACH_PX)[REACH_PX]) ** 2
