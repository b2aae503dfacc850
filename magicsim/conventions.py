"""Units, frame and image orientation that every part of magicsim shares.

Units: mm, N, MPa (= N/mm2), s, degrees. Frame: right-handed, origin at the centre of the contact face, x along the
24 mm side, y along the 32 mm side, +z from the contact face into the sensor towards the camera; the body fills
0 <= z <= height and objects come from -z. Force is what the object exerts on the sensor, so a press is +z.
Images are (rows, columns, 3) RGB; row 0 is at +y, column 0 at -x.
"""

IMAGE_ROWS = 320
"""Default number of image rows, along y."""

IMAGE_COLUMNS = 240
"""Default number of image columns, along x."""

CHANNELS = ("red", "green", "blue")
"""Order of the colour channels in every image."""

MAX_PIXELS = 50_000_000
"""Largest picture that is read: more than any sensor's camera has, and 150 MB decoded."""
