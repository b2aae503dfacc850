"""Markers on the contact face or below it: dots in a pattern, or a picture. `[markers]` in a design."""

from collections import defaultdict
from itertools import islice, product, repeat
from math import floor, hypot
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.models import Config
from magicsim.config.named_files import FileName
from magicsim.config.presets import PATHS_START, is_file
from magicsim.errors import ConfigError
from magicsim.folder.listing import sha256_of
from magicsim.geometry.coat import Color
from magicsim.notebook.screen import from_srgb

Depth = Annotated[float, Field(ge=0, le=25)]
MOST_MARKERS = 20_000
ROUNDING_MM = 1e-9
GREY_STEP = 1 / 255
"""Difference of channels up to which a pixel counts as grey."""
HALF = 0.5
"""Opacity from which on a pixel belongs to a spot."""
TRIES = 200
"""Places that are tried for each dot of a random pattern before it is left out."""
BLOCK = 1000
"""Places that are drawn at a time."""


class DotMarkers(Config):
    """Round dots."""

    kind: Literal["dots"]
    pattern: Literal["square", "hexagonal", "random"] = "square"
    """Arrangement, symmetric about the middle of the face; `random` keeps the mean density of `square` where dots find
    room for it, 1.1 diameters apart: up to 0.7 of the pitch they do."""
    pitch_mm: Annotated[float, Field(ge=0.2, le=50)]
    """Distance of neighbours [mm]."""
    diameter_mm: Annotated[float, Field(ge=0.05, le=20)]
    """Diameter [mm]."""
    color: Color = (0.02, 0.02, 0.02)
    """Diffuse reflectance in linear RGB."""
    depth_mm: Depth = 0.0
    """Depth below the contact face [mm]; 0 is printed on the face itself."""
    margin_mm: Annotated[float, Field(ge=0, le=50)] = 0.5
    """Least distance between a dot and the edge of the face [mm]."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of a random pattern."""

    def problem(self, footprint_mm: tuple[float, float], height_mm: float) -> str | None:
        """Why a block cannot have these markers, or None where it can."""
        if self.diameter_mm >= self.pitch_mm:
            return (
                f"markers.diameter_mm = {self.diameter_mm:g} is not allowed: must be below pitch_mm = {self.pitch_mm:g}"
            )
        reach = self.diameter_mm + 2 * self.margin_mm
        if reach > min(footprint_mm):
            return (
                f"markers lie outside of the face: diameter_mm + 2 * margin_mm = {reach:g} must be at most "
                f"{min(footprint_mm):g}, the face's shorter side"
            )
        if self.depth_mm >= height_mm:
            return f"markers.depth_mm = {self.depth_mm:g} is not allowed: must be below the height of {height_mm:g} mm"
        count = footprint_mm[0] * footprint_mm[1] / self.pitch_mm**2
        if count > MOST_MARKERS:
            return f"markers.pitch_mm = {self.pitch_mm:g} gives {count:.0f} markers: at most {MOST_MARKERS} are allowed"
        return None

    def centres_mm(self, footprint_mm: tuple[float, float]) -> Array:
        """Centres of the dots on the undeformed face of that size, shape (markers, 2) [mm], row by row."""
        room = np.array(footprint_mm) / 2 - self.margin_mm - self.diameter_mm / 2
        if self.pattern == "random":
            return self._scattered(room)
        rows_apart = self.pitch_mm * (np.sqrt(0.75) if self.pattern == "hexagonal" else 1.0)
        rows = _centred(room[1], rows_apart)
        dots = []
        for number, y in enumerate(rows):
            x = _centred(room[0], self.pitch_mm)
            if self.pattern == "hexagonal" and (number - len(rows) // 2) % 2:
                x = np.concatenate([x - self.pitch_mm / 2, [x[-1] + self.pitch_mm / 2]])
                x = x[np.abs(x) <= room[0] + ROUNDING_MM]
            dots.append(np.stack([x, np.full(len(x), y)], 1))
        return np.concatenate(dots)

    def _scattered(self, room: Array) -> Array:
        """At random, no two dots closer than a diameter and a tenth."""
        wanted = max(1, round(float(np.prod(2 * room)) / self.pitch_mm**2))
        apart, random = 1.1 * self.diameter_mm, np.random.default_rng(self.seed)
        tiles: dict[tuple[int, int], list[tuple[float, float]]] = defaultdict(list)
        dots: list[tuple[float, float]] = []
        places = (place for _ in repeat(None) for place in random.uniform(-room, room, (BLOCK, 2)).tolist())
        for _ in range(wanted):
            for x, y in islice(places, TRIES):
                column, row = floor(x / apart), floor(y / apart)
                around = product((column - 1, column, column + 1), (row - 1, row, row + 1))
                if all(hypot(x - other[0], y - other[1]) > apart for tile in around for other in tiles.get(tile, ())):
                    tiles[column, row].append((x, y))
                    dots.append((x, y))
                    break
        found = np.array(dots).reshape(-1, 2)
        return found[np.lexsort((found[:, 0], found[:, 1]))]


def _centred(room: float, step: float) -> Array:
    """Places a step apart, as many as fit, symmetric about 0."""
    count = 2 * int((room + ROUNDING_MM) // step) + 1
    return np.asarray(step * (np.arange(count) - count // 2))


class PictureMarkers(Config):
    """A picture on the contact face: its opaque pixels are printed, in their own colour."""

    kind: Literal["picture"]
    file: FileName
    """PNG with or without alpha, sRGB; without alpha all of it is printed. Rows run along -y, columns along x."""
    width_mm: Annotated[float, Field(ge=0.5, le=200)]
    """Width along x, with the picture's own proportions, centred on the face [mm]."""
    depth_mm: Annotated[float, Field(ge=0, le=0)] = 0.0
    """A picture is on the face."""

    def problem(self, footprint_mm: tuple[float, float], height_mm: float) -> str | None:
        """Why a block cannot have this picture, or None where it can."""
        if not is_file(Path(self.file)):
            return f"markers.file = '{self.file}' does not exist ({PATHS_START})"
        rows, columns = self.pixels().shape[:2]
        length = self.width_mm * rows / columns
        if self.width_mm > footprint_mm[0] or length > footprint_mm[1]:
            return (
                f"markers lie outside of the face: {self.width_mm:g} x {length:.4g} mm must fit into "
                f"{footprint_mm[0]:g} x {footprint_mm[1]:g} mm"
            )
        return None

    @property
    def is_grey(self) -> bool:
        """Whether no printed pixel has a colour."""
        pixels = self.pixels()
        printed = pixels[pixels[..., 3] > 0]
        return bool((np.ptp(printed[:, :3], axis=1) < GREY_STEP).all())

    def digest(self) -> str:
        """Digest of the file's content, which may be replaced by another of that name."""
        return sha256_of(Path(self.file))

    def pixels(self) -> Array:
        """Linear RGB and opacity, shape (rows, columns, 4) in 0..1; `ConfigError` where the file is no picture."""
        from PIL import Image

        try:
            with Image.open(self.file) as picture:
                values = np.asarray(picture.convert("RGBA"), np.float64) / 255
        except (OSError, Image.DecompressionBombError) as error:
            msg = f"markers.file = '{self.file}' is not allowed: must be a PNG file ({type(error).__name__})"
            raise ConfigError(msg) from None
        return np.concatenate([from_srgb(values)[..., :3], values[..., 3:]], -1)

    def centres_mm(self, footprint_mm: tuple[float, float]) -> Array:
        """Centroids of the printed spots on the undeformed face, shape (markers, 2) [mm], row by row from the top."""
        from scipy.ndimage import center_of_mass, label

        opaque = self.pixels()[..., 3] >= HALF
        spots, count = label(opaque)
        if count == 0:
            return np.zeros((0, 2))
        rows, columns = np.array(center_of_mass(opaque, spots, range(1, count + 1))).T
        pixel = self.width_mm / opaque.shape[1]
        x = (columns + 0.5 - opaque.shape[1] / 2) * pixel
        return np.stack([x, (opaque.shape[0] / 2 - rows - 0.5) * pixel], 1)


Markers = Annotated[DotMarkers | PictureMarkers, Field(discriminator="kind")]
