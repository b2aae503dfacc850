"""Image of a frame, anchored to the untouched sensor: the anchor's image and what the frame changes beyond noise.

Frames of an episode share their random numbers. Where nothing changed a frame has the very noise of the untouched
sensor's control image; where the grid is deformed its camera paths are others, and taking that noise off would add it.
So the share of the noise that both have is found from the images themselves, and how much of what is left is noise
follows from it: where that is most of what seems to have changed, little of it is shown.
"""

from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from magicsim.arrays import Array, FloatImage, Mask
from magicsim.camera.camera import Window

SPREAD_PX = 6.0
"""Standard deviation of the weights of neighbouring pixels [px]: half as much is noisier, more blurs what is local."""
NEAREST_PX = 12
"""Largest distance of such a neighbour along columns and rows [px]."""
LENGTHS_PX = (0.0, 2.0, 12.0)
"""Standard deviations of the local means along columns and along rows between which a change is taken apart [px]: walls
are about a pixel wide and stand along either, and what is smoother than the last both ways has hardly any noise. More
lengths between these, or longer ones, leave 1 to 3 % less error and cost twice the time."""
LENGTH_REACH_PX = 24
"""Largest distance of a pixel that such a mean takes in [px]."""
REACH_PX = 2 * NEAREST_PX + LENGTH_REACH_PX
"""Largest distance of a pixel that has a part in another's image along columns and rows [px]."""


def anchored_image(now: FloatImage, control: FloatImage, anchor: FloatImage, changed: Mask) -> FloatImage:
    """The anchor's image and the change that a frame shows, less shared noise.

    Detail keeps its contrast where it is more than noise (`benchmarks/detail.py`).

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
    change = change_beyond_noise(*(box.of(each) for each in (now, control, anchor)))
    box.of(result)[...] = np.where(box.of(changed)[..., None], box.of(anchor) + change, box.of(anchor))
    return result


def change_beyond_noise(now: FloatImage, control: FloatImage, anchor: FloatImage) -> Array:
    """How a frame differs from the untouched sensor as far as it is no noise, shape (rows, columns, 3).

    The difference is taken apart by length along columns and by length along rows: what a wall changes is long one way
    and short the other, and noise is short both ways. Of each part goes first the noise that both images share: its
    share is the linear regression on the control image's noise over all neighbours, with a constant for each channel.
    What is left has noise of variance n^2 = (1 - share^2) times that of the control image, and a mean square v over the
    neighbours. It counts by 1 - n^2 / v (Wiener's filter with the variance of the signal estimated where it is used),
    the part that is smoothest both ways wholly.

    A pixel's own values are left out, so that its own noise chooses neither its share nor its weight. Near the border
    the mirror brings them back with a weight of 1 % at most. Every pixel sums in one order: crops are exact.
    """
    changes, noises = (_by_length(each.astype(np.float64) - anchor) for each in (now, control))
    *fine, smooth = (_without_shared_noise(*each) for each in zip(changes, noises, strict=True))
    change = smooth[0]
    for part, own_noise in fine:
        squares = _of_neighbours(_summed(part**2))
        noise_part = np.divide(own_noise, squares, out=np.ones_like(squares), where=squares > 0)
        change = change + part * np.maximum(1 - noise_part, 0)
    return np.asarray(change)


def _by_length(values: Array) -> list[Array]:
    """Parts by length along columns and rows, the smoothest both ways last; their sum is what is given."""
    return [part for along in _along(values, 0) for part in _along(along, 1)]


def _along(values: Array, axis: int) -> list[Array]:
    """Differences between local means of growing width along one axis, and the widest."""
    means = [
        gaussian_filter1d(values, width, axis=axis, mode="mirror", radius=LENGTH_REACH_PX) if width else values
        for width in LENGTHS_PX
    ]
    return [fine - coarse for fine, coarse in pairwise(means)] + means[-1:]


def _without_shared_noise(changed: Array, noise: Array) -> tuple[Array, Array]:
    """A change less the noise that it shares, and the variance of the noise that it still has around each pixel."""
    around_changed, around_noise = _of_neighbours(changed), _of_neighbours(noise)
    # Over all channels together: the mean over neighbours of a sum is the sum of their means.
    shared = _of_neighbours(_summed(changed * noise)) - _summed(around_changed * around_noise)
    variance = np.maximum(_of_neighbours(_summed(noise**2)) - _summed(around_noise**2), 0)
    share = np.clip(np.divide(shared, variance, out=np.zeros_like(shared), where=variance > 0), 0, 1)
    return changed - share * noise, (1 - share**2) * variance


def _summed(values: Array) -> Array:
    """Over the channels, shape (rows, columns, 1)."""
    return np.asarray(values.sum(2, keepdims=True))


def _of_neighbours(values: Array) -> Array:
    """Weighted mean over the pixels around each, without itself, in every channel."""
    own = _own_weight()
    # Mirrored at the border, which the mean then does not count again.
    around = gaussian_filter(values, SPREAD_PX, mode="mirror", radius=NEAREST_PX, axes=(0, 1))
    return np.asarray((around - own * values) / (1 - own))


def _own_weight() -> float:
    pulse = np.zeros(2 * NEAREST_PX + 1)
    pulse[NEAREST_PX] = 1
    return float(gaussian_filter1d(pulse, SPREAD_PX, radius=NEAREST_PX)[NEAREST_PX]) ** 2
