"""Shape of the contact face: flat, a dome, or a height map. Configuration of `[face]` in a design.

A block with a curved face is its box, mapped: the plane at height zeta of the box goes to

    z = s(x, y) + zeta (H - s(x, y)) / H,

where H is the height at the crown and s the height of the face over the crown's plane z = 0. Planes of the grid follow
the face, as MagicTac's authors print them; the back stays flat on the lens, and the rest state is free of stress.
"""

import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PrivateAttr

from magicsim.arrays import Array
from magicsim.config.models import Config
from magicsim.config.named_files import FileName
from magicsim.config.presets import PATHS_START, is_file
from magicsim.errors import ConfigError
from magicsim.folder.listing import sha256_of

Radius = Annotated[float, Field(ge=1, le=1e6)]
MOST_SHARE = 0.6
"""Part of the height that a face may rise over its crown: cells beside the rim are thinner by as much."""


class Dome(Config):
    """A bulging face: the crown in the middle at z = 0, the rim higher, towards the lens."""

    kind: Literal["dome"]
    radius_x_mm: Radius | None = None
    """Radius of curvature along x at the crown [mm]; none is straight."""
    radius_y_mm: Radius | None = None
    """Radius of curvature along y at the crown [mm]; none is straight. Equal radii: a sphere; one alone: a cylinder."""
    crown_mm: Annotated[float, Field(gt=0, le=25)]
    """Height of the crown over the rim, beyond which the face goes on flat [mm]; a dome that has not fallen so far at
    the block's sides has no rim."""
    rim_mm: Annotated[float, Field(ge=0, le=25)] = 0.3
    """Height over which dome and rim blend [mm]; at most `crown_mm`."""

    def _problems(self) -> Iterator[str | None]:
        radii = [radius for radius in (self.radius_x_mm, self.radius_y_mm) if radius is not None]
        if not radii:
            yield "radius_x_mm and radius_y_mm are missing: a dome needs one of them"
        if self.crown_mm > min(radii):
            yield f"crown_mm = {self.crown_mm:g} is not allowed: must be at most the smaller radius, {min(radii):g}"
        if self.rim_mm > self.crown_mm:
            yield f"rim_mm = {self.rim_mm:g} is not allowed: must be at most crown_mm = {self.crown_mm:g}"

    def problem(self, height_mm: float) -> str | None:
        """Why a block cannot have this face, or None where it can."""
        if self.crown_mm > MOST_SHARE * height_mm:
            return (
                f"face.crown_mm = {self.crown_mm:g} is not allowed: must be at most {MOST_SHARE * height_mm:.4g}, "
                f"{MOST_SHARE:g} of the block's height of {height_mm:g} mm, or the rim would cut the grid"
            )
        return None

    def rise_mm(self, places_mm: Array) -> Array:
        """Height of the face over the crown's plane at places x, y of shape (..., 2) [mm].

        A surface of revolution about the crown for equal radii, a cylinder for one: q / (1 + sqrt(1 - p)) with
        q = x^2 / Rx + y^2 / Ry and p = x^2 / Rx^2 + y^2 / Ry^2.
        """
        squared = places_mm**2
        inverse = np.array([0.0 if radius is None else 1 / radius for radius in (self.radius_x_mm, self.radius_y_mm)])
        steep = squared @ inverse**2
        fallen = (squared @ inverse) / (1 + np.sqrt(np.maximum(1 - steep, 0)))
        fallen = np.where(steep < 1, fallen, np.inf)
        if self.rim_mm == 0:
            return np.minimum(fallen, self.crown_mm)
        blend = np.maximum(self.rim_mm - np.abs(np.minimum(fallen, 1e9) - self.crown_mm), 0)
        return np.asarray(np.minimum(fallen, self.crown_mm) - blend**2 / (4 * self.rim_mm))


class HeightMap(Config):
    """A free form, smooth at the scale of a cell: heights on a regular grid over the footprint."""

    kind: Literal["height_map"]
    file: FileName
    """NPY of heights [mm], or a PNG whose grey levels are heights; rows run along -y, columns along x, and the first
    and last of both lie on the block's sides."""
    footprint_mm: tuple[Annotated[float, Field(ge=2, le=200)], Annotated[float, Field(ge=2, le=200)]]
    """Size that it covers along x and y, the design's own [mm]."""
    range_mm: Annotated[float, Field(gt=0, le=25)] = 1.0
    """Height of a PNG's white over its black [mm]; larger is further out."""
    _content: str = PrivateAttr("")
    """Digest of the file: with another content under its name this is another face."""

    def model_post_init(self, _: object) -> None:
        """Notes what the file holds, where it is there."""
        path = Path(self.file)
        self._content = sha256_of(path) if is_file(path) else ""

    def problem(self, height_mm: float) -> str | None:
        """Why a block cannot have this face, or None where it can."""
        rise = float(-self._heights().min())
        if rise > MOST_SHARE * height_mm:
            return (
                f"face.file = '{self.file}' is not allowed: it falls {rise:.4g} mm, at most "
                f"{MOST_SHARE * height_mm:.4g} are, {MOST_SHARE:g} of the block's height"
            )
        return None

    def _heights(self) -> Array:
        path = Path(self.file)
        if not is_file(path):
            raise ConfigError(f"face.file = '{self.file}' does not exist ({PATHS_START})")
        heights = _read(self.file, self.range_mm, os.path.abspath(path), sha256_of(path))
        return np.asarray(heights - heights.max())

    def rise_mm(self, places_mm: Array) -> Array:
        """Height of the face over the crown's plane at places x, y of shape (..., 2) [mm]: a cubic spline."""
        from scipy.ndimage import map_coordinates

        heights = self._heights()
        rows, columns = heights.shape
        x = (places_mm[..., 0] / self.footprint_mm[0] + 0.5) * (columns - 1)
        y = (0.5 - places_mm[..., 1] / self.footprint_mm[1]) * (rows - 1)
        raised = map_coordinates(heights, [np.ravel(y), np.ravel(x)], order=3, mode="nearest")
        return np.asarray(-raised.reshape(np.shape(x)))


@lru_cache(maxsize=4)
def _read(file: str, range_mm: float, _whole_path: str, _digest: str) -> Array:
    """Heights of a file, which its whole path and its content tell from others of its name [mm]."""
    from PIL import Image

    path, problem = Path(file), f"face.file = '{file}' is not allowed: must be a PNG or an NPY of two dimensions"
    try:
        if path.suffix == ".npy":
            heights = np.asarray(np.load(path), np.float64)
        else:
            with Image.open(path) as picture:
                is_deep = picture.mode.startswith("I")
                heights = np.asarray(picture.convert("I" if is_deep else "L"), np.float64)
                heights *= range_mm / (65535 if is_deep else 255)
    except (OSError, ValueError, EOFError, Image.DecompressionBombError) as error:
        raise ConfigError(f"{problem} ({type(error).__name__})") from None
    if heights.ndim != 2 or min(heights.shape) < 4 or not np.isfinite(heights).all():  # noqa: PLR2004 -- a cubic's
        raise ConfigError(f"{problem} of at least 4 x 4 finite heights")
    return heights


Face = Annotated[Dome | HeightMap, Field(discriminator="kind")]


def lifted(points_mm: Array, face: Dome | HeightMap | None, height_mm: float) -> Array:
    """Points of the box, shape (..., 3) [mm], where a block of that height has them; the same array for a flat face."""
    if face is None:
        return points_mm
    rise = face.rise_mm(points_mm[..., :2])
    z = rise + points_mm[..., 2] * (height_mm - rise) / height_mm
    return np.concatenate([points_mm[..., :2], z[..., None]], -1)


def flattened(points_mm: Array, face: Dome | HeightMap | None, height_mm: float) -> Array:
    """Points of the block where its box has them: the inverse of `lifted`."""
    if face is None:
        return points_mm
    rise = face.rise_mm(points_mm[..., :2])
    z = (points_mm[..., 2] - rise) * height_mm / (height_mm - rise)
    return np.concatenate([points_mm[..., :2], z[..., None]], -1)
