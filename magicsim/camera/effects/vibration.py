"""A mount that shakes: the whole image lies a little beside its place in every frame."""

import cv2
import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.effects.randomness import SHAKE, deviates


def shift_px(vibration_px: float, *, seed: int, frame: int) -> Array:
    """Shift down and right, shape (2,) [px]; frames are independent, as of a motion faster than the frame rate.

    Args:
        vibration_px: Standard deviation along rows and along columns [px].
        seed: Of the episode.
        frame: Its number in the stream.
    """
    return np.asarray(vibration_px * deviates(seed, frame, SHAKE).standard_normal(2))


def shifted(image: FloatImage, by_px: Array) -> FloatImage:
    """The image moved down and right by parts of a pixel; its mirror comes in from beyond the border.

    Args:
        image: Linear radiance, shape (rows, columns, 3).
        by_px: Shape (2,) [px].
    """
    down, across = (_taps(float(each)) for each in by_px)
    return np.asarray(cv2.sepFilter2D(image, -1, across, down, borderType=cv2.BORDER_REFLECT_101), np.float32)


def _taps(by_px: float) -> Array:
    """Weights of the pixels around one, for what lies so far before it.

    Cubic convolution with a = -1/2 (Keys, *IEEE Trans. ASSP* 29, 1153, 1981).
    """
    reach = int(abs(by_px)) + 2
    away = np.abs(np.arange(-reach, reach + 1) + by_px)
    near = (1.5 * away - 2.5) * away**2 + 1
    far = ((-0.5 * away + 2.5) * away - 4) * away + 2
    return np.where(away <= 1, near, np.where(away < 2, far, 0.0))  # noqa: PLR2004 - pieces of the polynomial
