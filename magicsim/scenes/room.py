"""What surrounds a sensor, from all directions: an equirectangular image in the place of even light.

The middle of the image is where the sensor looks (-z), its upper edge +y, its right half +x. Its linear radiance is
scaled so that the mean over all directions in each channel is `Rig.ambient`, whatever the image's own exposure.
"""

import os
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import numpy as np
from PIL import Image
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.documents import read_toml
from magicsim.config.models import Config, validate
from magicsim.config.named_files import is_picture
from magicsim.config.presets import expanded, is_file, preset_root
from magicsim.errors import ConfigError, unknown_choice
from magicsim.folder.listing import sha256_of
from magicsim.geometry.coat import Color
from magicsim.notebook.screen import from_srgb

STREAM = 0x9A55
"""Keeps its random numbers apart from others of a scene's seed."""
OUT_OF_SIGHT = 5.0
"""Sideways distance, in units of the distance ahead, from which on it is not there: 79 degrees from the axis."""
Size = Annotated[float, Field(ge=1, le=10_000)]
FOLDER = "scenes/rooms"
MOST_COLUMNS = 4096
MODES = ("L", "LA", "P", "RGB", "RGBA")
"""Kinds of pixels, as Pillow calls them, that are taken for sRGB."""


class Passing(Config):
    """An upright thing with soft edges that crosses what the sensor looks at, again and again, at one speed.

    It moves along x, at one distance in front of the contact face, and hides what is behind it; its own radiance is
    that of a matt surface in the room's mean light. Times of passage and direction follow from the scene's seed. A
    person by default; all values are assumed.
    """

    distance_mm: Annotated[float, Field(ge=50, le=100_000)] = 1500.0
    """From the contact face, along the sensor's axis [mm]; what approaches the sensor has to stay before it."""
    speed_mm_s: Annotated[float, Field(ge=1, le=100_000)] = 1000.0
    """Speed [mm/s]; people walk at 1000 to 1500."""
    size_mm: tuple[Size, Size] = (450.0, 1700.0)
    """Width and height [mm]."""
    rise_mm: Annotated[float, Field(ge=-100_000, le=100_000)] = -200.0
    """Height of its middle over the sensor's axis, along y [mm]."""
    reflectance: Color = (0.12, 0.15, 0.25)
    """Diffuse reflectance, linear RGB."""
    every_s: Annotated[float, Field(ge=0.1, le=3600)] = 8.0
    """Time from one passage to the next [s]."""

    def place_mm(self, time_s: float, seed: int) -> float | None:
        """Where its middle is along x [mm], or None while it is out of sight."""
        random = np.random.default_rng(np.random.SeedSequence([seed, STREAM]))
        begun, way = random.uniform(0, self.every_s), random.choice((-1, 1))
        place = float(way) * self.speed_mm_s * ((time_s + begun) % self.every_s - self.every_s / 2)
        return round(place, 6) if abs(place) < OUT_OF_SIGHT * self.distance_mm else None


def room_names() -> list[str]:
    """Names of the rooms that come with the program, sorted."""
    return sorted(path.stem for path in (preset_root() / FOLDER).glob("*.png"))


def room_file(name: str) -> Path:
    """The image of a room by one of `room_names()`, or by path; `ConfigError` where it is neither."""
    if name in room_names():
        return preset_root() / FOLDER / f"{name}.png"
    path = expanded(name)
    if not is_picture(name):
        raise ConfigError(unknown_choice("room (or a PNG or JPEG file)", name, ["dark", *room_names()]))
    if not is_file(path):
        msg = f"rig.room = '{name}' does not exist; give a PNG or JPEG file or one of: dark, {', '.join(room_names())}"
        raise ConfigError(msg)
    return path


@lru_cache(maxsize=16)
def room_passing(name: str) -> Passing | None:
    """What passes in a room by itself: a table in a TOML file beside its image, None where there is none."""
    path = room_file(name).with_suffix(".toml") if name in room_names() else None
    return validate(Passing, read_toml(path), source=path.name) if path is not None and is_file(path) else None


def room_radiance(name: str) -> Array:
    """Radiance from all directions with a mean of 1 in each channel, shape (rows, columns, 3).

    `ConfigError` where the file holds no equirectangular image, or a black one.
    """
    path = room_file(name)
    return _read(path, os.path.abspath(path), sha256_of(path))


@lru_cache(maxsize=4)
def _read(path: Path, _whole_path: str, _digest: str) -> Array:
    linear = from_srgb(_pixels(path))
    mean = (linear * solid_angles(len(linear))[:, None, None]).sum(0).mean(0)
    if not (mean > 0).all():
        raise ConfigError(f"rig.room '{path.name}' is black in a channel: there is nothing to scale to rig.ambient")
    return np.asarray(linear / mean)


def _pixels(path: Path) -> Array:
    """Coded values from 0 to 1, shape (rows, columns, 3)."""
    unreadable = ConfigError(f"rig.room '{path.name}' is no image that can be read")
    try:
        picture = Image.open(path)
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise unreadable from error
    with picture:
        if picture.mode not in MODES:
            raise ConfigError(
                f"rig.room '{path.name}' has pixels of kind {picture.mode}: must be 8-bit grey or RGB, with or without "
                "alpha"
            )
        columns, rows = picture.size
        if columns != 2 * rows or columns > MOST_COLUMNS:
            raise ConfigError(
                f"rig.room '{path.name}' has {columns} x {rows} pixels: must be twice as wide as high, at most "
                f"{MOST_COLUMNS} wide"
            )
        try:
            return np.asarray(picture.convert("RGB"), np.float64) / 255
        except (OSError, ValueError) as error:
            raise unreadable from error


def solid_angles(rows: int) -> Array:
    """Share of all directions that each row of an equirectangular image stands for, shape (rows,)."""
    edges = np.cos(np.linspace(0, np.pi, rows + 1))
    return np.asarray((edges[:-1] - edges[1:]) / 2)
