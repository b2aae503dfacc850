"""Image of a frame, anchored to the untouched sensor: its careful image and what the frame changes beyond noise."""

import numpy as np
import numpy.typing as npt

from magicsim.camera.window import Window
from magicsim.light.frame import shared_noise, wiener

FloatImage = npt.NDArray[np.float32]
REACH_PX = shared_noise.REACH_PX + wiener.REACH_PX
"""How far around a pixel its anchored value looks, along columns and rows [px]."""


def anchored_image(
    now: FloatImage, cheap: FloatImage, careful: FloatImage, changed: npt.NDArray[np.bool_]
) -> FloatImage:
    """The careful image and the change that a frame shows, less shared noise, as far as it stands out of its own.

    A press changes much in a few pixels and next to nothing in most of them, where the frame's noise would otherwise be
    all that differs from rest. Local means are kept; detail fainter than noise at rest is not.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        cheap: The untouched sensor with the frame's random numbers and samples, of the same shape.
        careful: The untouched sensor with many samples, of the same shape.
        changed: Which pixels the frame can change, shape (rows, columns); the others are the careful ones.
    """
    result = careful.copy()
    if not changed.any():
        return result
    rows, columns = (np.flatnonzero(changed.any(axis)) for axis in (1, 0))
    box = Window(
        column=int(columns[0]), row=int(rows[0]), columns=int(np.ptp(columns)) + 1, rows=int(np.ptp(rows)) + 1
    ).grown(REACH_PX, changed.shape[1], changed.shape[0])
    change, variance = shared_noise.change_and_noise(*(box.of(each) for each in (now, cheap, careful)))
    part = np.maximum(box.of(careful) + wiener.filtered(change, variance), 0)
    box.of(result)[...] = np.where(box.of(changed)[..., None], part, box.of(careful))
    return result
