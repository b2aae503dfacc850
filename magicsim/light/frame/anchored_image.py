"""Image of a frame, anchored to the untouched sensor: its careful image and what the frame changes."""

import numpy as np

from magicsim.arrays import FloatImage, Mask
from magicsim.camera.camera import Window
from magicsim.light.frame.shared_noise import REACH_PX, change_without_shared_noise


def anchored_image(now: FloatImage, cheap: FloatImage, careful: FloatImage, changed: Mask) -> FloatImage:
    """The careful image and the change that a frame shows, less shared noise.

    Nothing smooths it: detail keeps its contrast (`benchmarks/detail.py`), and noise that is the frame's own stays.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        cheap: The untouched sensor with the frame's random numbers and samples, of the same shape.
        careful: The untouched sensor with many samples, of the same shape.
        changed: Which pixels the frame can change, shape (rows, columns); the others are the careful ones.
    """
    change = anchored_change(now, cheap, careful, changed)
    return np.where(changed[..., None], np.maximum(change, 0), change)


def anchored_change(now: FloatImage, cheap: FloatImage, careful: FloatImage, changed: Mask) -> FloatImage:
    """`anchored_image` of values that may be negative, as those are that one light changes.

    Args:
        now: See there.
        cheap: See there.
        careful: See there.
        changed: See there.
    """
    result = careful.copy()
    if not changed.any():
        return result
    rows, columns = (np.flatnonzero(changed.any(axis)) for axis in (1, 0))
    box = Window(
        column=int(columns[0]), row=int(rows[0]), columns=int(np.ptp(columns)) + 1, rows=int(np.ptp(rows)) + 1
    ).grown(REACH_PX, changed.shape[1], changed.shape[0])
    change = change_without_shared_noise(*(box.of(each) for each in (now, cheap, careful)))
    box.of(result)[...] = np.where(box.of(changed)[..., None], box.of(careful) + change, box.of(careful))
    return result
