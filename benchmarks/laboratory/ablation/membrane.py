"""A fake to compare with: an opaque membrane shaded from its height map, as simulators of opaque gels do.

Lambert's law under one parallel light for each LED strip, from its side and at a fixed elevation. Nothing behind the
membrane is seen, and no light comes through it.
"""

import numpy as np
import numpy.typing as npt

from magicsim.scenes.rig import LedStrip

Array = npt.NDArray[np.float64]
FloatImage = npt.NDArray[np.float32]
ELEVATION_DEG = 30.0
"""Of the lights over the membrane [degrees]; assumed."""


def shade_membrane(depth_mm: Array, landing_mm: Array, strips: tuple[LedStrip, ...]) -> FloatImage:
    """Linear radiance of a membrane, shape (rows, columns, 3).

    Args:
        depth_mm: How far it is pressed in at each pixel, shape (rows, columns) [mm].
        landing_mm: x and y of the pixels, evenly spaced, row 0 at +y, shape (rows, columns, 2) [mm].
        strips: Lights, by side and radiance.
    """
    step_x = landing_mm[0, 1, 0] - landing_mm[0, 0, 0]
    step_y = landing_mm[1, 0, 1] - landing_mm[0, 0, 1]
    along_y, along_x = np.gradient(depth_mm)
    normal = np.stack([-along_x / step_x, -along_y / step_y, np.ones_like(depth_mm)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    image = np.zeros((*depth_mm.shape, 3))
    for strip in strips:
        lit = np.clip(normal @ _towards(strip.side), 0, None)
        image += lit[..., None] * np.array(strip.radiance)
    return np.asarray(image, np.float32)


def _towards(side: str) -> Array:
    """Unit vector from the membrane towards the light of a side, shape (3,)."""
    elevation = np.radians(ELEVATION_DEG)
    flat = np.zeros(3)
    flat["xy".index(side[1])] = 1.0 if side[0] == "+" else -1.0
    return np.asarray(np.cos(elevation) * flat + np.sin(elevation) * np.array([0.0, 0.0, 1.0]))
