"""The real frames in blocks of pixels, their rings about the contact, and what a camera makes of radiance."""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from laboratory.real_frames.constants import Constants
from magicsim.arrays import Array

FOLDER = Path("docs/real-frames")
COLUMNS, ROWS, STEP = 92, 69, 5
MIDDLE_PX, PIXEL_MM = (245, 190), 0.0510
EDGES_MM = np.arange(0, 11.6, 0.5)
MIDDLES_MM = (EDGES_MM[1:] + EDGES_MM[:-1]) / 2


def observed(name: str) -> Array:
    """Mean grey level of the three channels in blocks of 5 x 5 pixels, shape (69, 92)."""
    image = np.asarray(cv2.imread(str(FOLDER / f"{name}.png")), np.float64)
    return np.asarray(image.reshape(ROWS, STEP, COLUMNS, STEP, 3).mean((1, 3, 4)))


def profile(frame: Array) -> Array:
    """Mean over rings about the middle of the contact, shape (rings,)."""
    x = (np.arange(COLUMNS) * STEP + STEP // 2 - MIDDLE_PX[0]) * PIXEL_MM
    y = (np.arange(ROWS) * STEP + STEP // 2 - MIDDLE_PX[1]) * PIXEL_MM
    radius = np.hypot(*np.meshgrid(x, y))
    return np.array([frame[(radius >= low) & (radius < high)].mean() for low, high in pairwise(EDGES_MM)])


def shade(vignetting: float) -> Array:
    """What the lens lets pass, as `rig.camera.vignetting` has it, shape (69, 92)."""
    x, y = np.meshgrid(np.arange(COLUMNS) - (COLUMNS - 1) / 2, np.arange(ROWS) - (ROWS - 1) / 2)
    return np.asarray(1 - vignetting * (x**2 + y**2) / ((COLUMNS**2 + ROWS**2) / 4))


def grey(radiance: Array, camera: Constants, shading: Array) -> Array:
    """Grey levels of radiances, both of the shape of `shading`."""
    return np.asarray(255 * np.clip(np.exp(camera.exposure) * radiance * shading, 0, 1) ** (1 / camera.gamma))


def features(drop: Array) -> dict[str, float]:
    """Drop in the middle, height of the bright ring, and radius where the sign changes, of a profile."""
    first = int(np.argmax(drop < 0))
    crossing = np.interp(0, [-drop[first - 1], -drop[first]], [MIDDLES_MM[first - 1], MIDDLES_MM[first]])
    return {
        "centre_drop_grey": float(drop[0]),
        "ring_grey": float(-np.nanmin(drop)),
        "crossing_mm": float(crossing),
    }
