"""What a screen shows of a camera's frames: sRGB's tone curve, and beside each frame its change against rest.

Nothing here touches frames that are stored: those stay as the camera gives them.
"""

import numpy as np

from magicsim.arrays import AnyArray, Array, Frame

KNEE, LINEAR_KNEE, SLOPE = 0.04045, 0.0031308, 12.92
"""Coded and linear share of white below which sRGB is a straight line, and its slope (IEC 61966-2-1)."""
STRONGER, MID_GREY, EDGE_PX = 4, 128, 4
"""How much stronger a change is shown, around which grey level, and the width of the black line before it [px]."""


def from_srgb(coded: Array) -> Array:
    """Linear light of shares of white in sRGB's tone curve (IEC 61966-2-1), any shape."""
    return np.where(coded <= KNEE, coded / SLOPE, ((coded + 0.055) / 1.055) ** 2.4)


def to_srgb(linear: Array) -> Array:
    """Linear light, at least 0, in sRGB's tone curve (IEC 61966-2-1), any shape; 1 is white in both."""
    return np.where(linear <= LINEAR_KNEE, SLOPE * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


SHOWN = np.rint(255 * to_srgb(np.arange(256) / 255)).astype(np.uint8)
"""What a screen is sent for each grey level of a camera that is linear in light."""


def on_screen(image: Frame, *, gamma: float | None) -> Frame:
    """A frame for a screen, shape (rows, columns, 3).

    At a gamma of 1 grey levels are linear in light and get sRGB's tone curve; at others, and at None, that of an
    unknown camera, they count as coded already and stay as they are.
    """
    return np.asarray(SHOWN[image]) if gamma == 1 else image


def change(image: Frame, rest: AnyArray) -> Frame:
    """How a frame differs from the untouched sensor: `STRONGER` times the grey levels more, around `MID_GREY`."""
    return np.clip(np.rint(MID_GREY + STRONGER * (image.astype(np.float64) - rest)), 0, 255).astype(np.uint8)


def beside_change(image: Frame, rest: AnyArray | None, *, gamma: float | None) -> Frame:
    """A frame as `on_screen`, and right of it its `change`; the frame alone where nothing is known of rest."""
    shown = on_screen(image, gamma=gamma)
    if rest is None:
        return shown
    return np.hstack([shown, np.zeros((len(image), EDGE_PX, 3), np.uint8), change(image, rest)])
