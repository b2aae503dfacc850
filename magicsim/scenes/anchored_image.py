"""Image of a frame, anchored to the untouched sensor: its careful image and what the frame changes beyond noise."""

import numpy as np
import numpy.typing as npt

from magicsim.scenes import shared_noise, wiener

FloatImage = npt.NDArray[np.float32]
REACH_PX = shared_noise.REACH_PX + wiener.REACH_PX
"""How far around a pixel its anchored value looks, along columns and rows [px]."""


def anchored_image(now: FloatImage, cheap: FloatImage, careful: FloatImage) -> FloatImage:
    """The careful image and the change that a frame shows, less shared noise, as far as it stands out of its own.

    A press changes much in a few pixels and next to nothing in most of them, where the frame's noise would otherwise be
    all that differs from rest. Local means are kept; detail fainter than noise at rest is not.

    Args:
        now: Radiance of the frame, shape (rows, columns, 3).
        cheap: The untouched sensor with the frame's random numbers and samples, of the same shape.
        careful: The untouched sensor with many samples, of the same shape.
    """
    change, variance = shared_noise.change_and_noise(now, cheap, careful)
    return np.asarray(np.maximum(careful + wiener.filtered(change, variance), 0), np.float32)
