"""Draws the rooms of `scenes/rooms`: what a sensor's surroundings look like, as equirectangular images.

    python docs/rooms.py [--out scenes/rooms]

The middle of an image is where the sensor looks, its upper edge +y. The sensor is taken to look ahead as a hand does
that reaches for something on a bench: floor and bench below, lamps above. Colours and sizes are examples (assumed).
Lamps are cut off at white, about ten times as bright as a wall; real ones are brighter still.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.notebook.screen import to_srgb

Array = npt.NDArray[np.float64]
ROWS, COLUMNS = 128, 256
LAMP = 1.0
"""Brightest that 8 bit hold; walls are a tenth of it."""


class Sphere:
    """A picture of all directions; azimuth 0 and elevation 0 are straight ahead [degrees]."""

    def __init__(self, wall: tuple[float, float, float]) -> None:
        """A wall all around.

        Args:
            wall: Linear radiance of each channel, 1 at white.
        """
        row, column = np.mgrid[:ROWS, :COLUMNS]
        self.elevation = 90 - (row + 0.5) / ROWS * 180
        self.azimuth = (column + 0.5) / COLUMNS * 360 - 180
        self.image = np.ones((ROWS, COLUMNS, 3)) * wall

    def patch(
        self, azimuth: tuple[float, float], elevation: tuple[float, float], color: tuple[float, float, float]
    ) -> None:
        """Fills a range of directions."""
        inside = (azimuth[0] <= self.azimuth) & (self.azimuth < azimuth[1])
        inside &= (elevation[0] <= self.elevation) & (self.elevation < elevation[1])
        self.image[inside] = color


def office() -> Array:
    """White walls, four ceiling panels, a bench of wood, a blue screen and a shelf of books."""
    room = Sphere((0.105, 0.1, 0.09))
    room.patch((-180, 180), (45, 90), (0.14, 0.14, 0.13))
    for left in (-150, -60, 30, 120):
        room.patch((left, left + 35), (52, 68), (LAMP, 0.97, 0.9))
    room.patch((-180, 180), (-90, -25), (0.1, 0.065, 0.035))
    room.patch((-70, -30), (-12, 18), (0.03, 0.09, 0.3))
    room.patch((55, 120), (-15, 30), (0.05, 0.03, 0.03))
    for shelf in range(13):
        color = ((0.18, 0.03, 0.02), (0.02, 0.08, 0.12), (0.12, 0.1, 0.03))[shelf % 3]
        room.patch((55 + 5 * shelf, 58.5 + 5 * shelf), (-8, 6), color)
    return room.image


def window() -> Array:
    """A dim room with a bright, bluish window on one side."""
    room = Sphere((0.035, 0.033, 0.03))
    room.patch((-180, 180), (-90, -25), (0.03, 0.02, 0.012))
    room.patch((35, 95), (-10, 45), (0.75, 0.9, LAMP))
    room.patch((63, 67), (-10, 45), (0.05, 0.05, 0.05))
    room.patch((35, 95), (-10, 2), (0.12, 0.3, 0.1))
    return room.image


def bench() -> Array:
    """A green mat, tools of metal and a desk lamp above, in a dark laboratory."""
    room = Sphere((0.02, 0.02, 0.022))
    room.patch((-180, 180), (-90, -15), (0.03, 0.11, 0.06))
    room.patch((-25, 25), (35, 60), (LAMP, 0.85, 0.6))
    room.patch((-60, -20), (-40, -30), (0.25, 0.25, 0.27))
    room.patch((15, 45), (-55, -35), (0.3, 0.04, 0.03))
    return room.image


def corridor() -> Array:
    """Light walls, a door, a strip of lamps along the ceiling; somebody passes (`corridor.toml`)."""
    room = Sphere((0.11, 0.11, 0.1))
    room.patch((-180, 180), (55, 90), (0.13, 0.13, 0.13))
    room.patch((-180, 180), (62, 72), (0.8, 0.85, 0.85))
    room.patch((-180, 180), (-90, -30), (0.05, 0.05, 0.055))
    room.patch((-180, 180), (-5, -1), (0.04, 0.1, 0.09))
    room.patch((-50, -15), (-30, 25), (0.07, 0.045, 0.02))
    room.patch((100, 150), (-10, 30), (0.3, 0.4, 0.5))
    return room.image


ROOMS = {"office": office, "window": window, "bench": bench, "corridor": corridor}


def encoded(image: Array) -> npt.NDArray[np.uint8]:
    """The image in sRGB's tone curve (IEC 61966-2-1)."""
    return np.asarray(np.rint(255 * np.clip(to_srgb(image), 0, 1)), np.uint8)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("scenes/rooms"))
    folder = parser.parse_args().out
    for name, draw in ROOMS.items():
        soft = cv2.GaussianBlur(draw(), (0, 0), 1.0)
        cv2.imwrite(str(folder / f"{name}.png"), encoded(soft)[..., ::-1])
