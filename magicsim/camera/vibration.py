"""A mount that shakes: the whole image lies a little beside its place in every frame."""

import numpy as np
import numpy.typing as npt
from scipy.ndimage import shift

from magicsim.camera.randomness import SHAKE, deviates

FloatImage = npt.NDArray[np.float32]


def shift_px(vibration_px: float, *, seed: int, frame: int) -> npt.NDArray[np.float64]:
    """Shift down and right, shape (2,) [px]; frames are independent, as of a motion faster than the frame rate.

    Args:
        vibration_px: Standard deviation along rows and along columns [px].
        seed: Of the episode.
        frame: Its number in the stream.
    """
    return np.asarray(vibration_px * deviates(seed, frame, SHAKE).standard_normal(2))


def shifted(image: FloatImage, by_px: npt.NDArray[np.float64]) -> FloatImage:
    """The image moved down and right by parts of a pixel (cubic spline; its mirror beyond the border).

    Args:
        image: Linear radiance, shape (rows, columns, 3).
        by_px: Shape (2,) [px].
    """
    return np.asarray(shift(image, (*by_px, 0), order=3, mode="mirror"), np.float32)
