"""The camera and the lens plate in front of it: the tables `rig.camera` and `rig.lens` of a scene."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field

from magicsim.camera.effect_settings import (
    H264,
    Compression,
    Diffraction,
    Dust,
    Flicker,
    Glare,
    LedDrift,
    LiveExposure,
    PixelFaults,
    Shutter,
)
from magicsim.config.models import Config
from magicsim.conventions import IMAGE_COLUMNS, IMAGE_ROWS

Share = Annotated[float, Field(ge=-10, le=10)]
Row = tuple[Share, Share, Share]
Coefficient = Annotated[float, Field(ge=-1, le=1)]
Pixel = Annotated[int, Field(ge=0, le=2047)]
PixelCount = Annotated[int, Field(ge=8, le=2048)]
Offset = Annotated[float, Field(ge=-1024, le=1024)]
WHOLE_IMAGE = {"live": None, "vibration_px": 0.0, "glare": None, "diffraction": None, "compression": None}
"""What cannot be had of a part of the image, and its value without."""


@dataclass(slots=True, kw_only=True)
class Window:
    """Columns and rows from a first one."""

    column: int
    row: int
    columns: int
    rows: int

    @classmethod
    def whole(cls, columns: int, rows: int) -> Self:
        """The whole image."""
        return cls(column=0, row=0, columns=columns, rows=rows)

    def grown(self, margin: int, columns: int, rows: int) -> Self:
        """With a margin on each side, as far as the image of so many columns and rows goes."""
        left, top = max(0, self.column - margin), max(0, self.row - margin)
        right, bottom = min(columns, self.column + self.columns + margin), min(rows, self.row + self.rows + margin)
        return replace(self, column=left, row=top, columns=right - left, rows=bottom - top)

    def within(self, other: Self) -> Self:
        """These pixels, counted from the first ones of another window."""
        return replace(self, column=self.column - other.column, row=self.row - other.row)

    def numbers(self, columns: int, rows: int) -> npt.NDArray[np.uint32]:
        """Numbers of its pixels in an image of so many columns and rows, counted row by row; shape (pixels,)."""
        return np.asarray(self.of(np.arange(columns * rows, dtype=np.uint32).reshape(rows, columns)).ravel())

    def of(self, image: Any) -> Any:
        """That part of an image, shape (rows, columns, ...)."""
        return image[self.row : self.row + self.rows, self.column : self.column + self.columns]


class Lens(Config):
    """Clear plate between block and camera, bonded to the block and matched to its index."""

    thickness_mm: Annotated[float, Field(ge=0, le=20)] = 2.0
    """Thickness [mm]; 0 leaves it out."""


class Camera(Config):
    """Camera on the sensor's axis: pinhole, lens, and the sensor behind it."""

    columns: Annotated[int, Field(ge=8, le=2048)] = IMAGE_COLUMNS
    """Image width [px]."""
    rows: Annotated[int, Field(ge=8, le=2048)] = IMAGE_ROWS
    """Image height [px]."""
    region_px: tuple[Pixel, Pixel, PixelCount, PixelCount] | None = None
    """Part of the image that is read out: first column and row, number of columns and rows; the whole image by default.
    Its pixels, noise included, are those of the whole image."""
    distance_mm: Annotated[float, Field(ge=1, le=2000)] = 24.0
    """Distance of the pinhole from the outer face of the lens [mm]."""
    field_mm: Annotated[float, Field(ge=0.1, le=1000)] = 22.8
    """Width along x that the image covers on the undeformed contact face, refraction included and the distortion of
    the lens left out [mm]."""
    principal_offset_px: tuple[Offset, Offset] = (0.0, 0.0)
    """Where the optical axis meets the image, right and down from its centre [px]."""
    distortion: tuple[Coefficient, Coefficient, Coefficient, Coefficient, Coefficient] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """Distortion of the lens: OpenCV's k1, k2, p1, p2, k3."""
    vignetting: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Share of the light that is lost at the image's corners; it grows with the square of the distance."""
    blur_px: Annotated[float, Field(ge=0, le=10)] = 0.7
    """Standard deviation of the point spread of lens, focus and pixels [px]; assumed, 0.5 to 1.5: interpolated colour
    filters alone blur by half a pixel, and a block of 6.6 mm is deeper than a small lens 24 mm away has in focus."""
    rendered_px: Annotated[float, Field(ge=1, le=8)] = 1.0
    """Edge of the pixels that are rendered [px]; the camera's pixels are interpolated between larger ones. 2 renders a
    quarter as many, which blurs by about a pixel: for previews and control loops."""
    exposure_grey: Annotated[float, Field(ge=1, le=254)] = 90.0
    """Mean grey level of the untouched frame that auto-exposure aims at, before it locks."""
    white_balance: bool = True
    """Whether auto-exposure gives each channel its own gain, so that all have the same mean."""
    color_matrix: tuple[Row, Row, Row] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    """What the sensor's red, green and blue pixels see of the light's red, green and blue; one row each."""
    gamma: Annotated[float, Field(ge=0.3, le=4)] = 1.0
    """Exponent of the tone curve: grey = 255 * signal^(1 / gamma)."""
    full_well_e: Annotated[float, Field(ge=10, le=1e12)] = 250_000.0
    """Photo-electrons at grey level 255, counted over all exposures that the driver's temporal denoising averages:
    about 0.3 grey levels rms in the middle of the range, which the published entropy threshold of 0.5 implies."""
    read_noise_e: Annotated[float, Field(ge=0, le=1e12)] = 50.0
    """Standard deviation of the read noise [electrons], counted likewise."""
    fixed_pattern: Annotated[float, Field(ge=0, le=0.2)] = 0.005
    """Relative standard deviation of the pixels' gains, constant in time."""
    pattern_seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of that pattern: it belongs to the camera, not to an episode."""
    live: LiveExposure | None = None
    """Exposure and white balance that follow the image; locked by default."""
    shutter: Shutter = Shutter()
    """When the rows collect light, for flicker and motion."""
    flicker: Flicker | None = None
    """Flicker of the room's light, as far as `ambient` lights the untouched sensor; none by default."""
    led_drift: LedDrift | None = None
    """Drift of the strips' light; none by default."""
    vibration_px: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Standard deviation of the image's place along rows and columns, another in each frame [px]; assumed, 0 to 0.1."""
    glare: Glare | None = None
    """Light that lens and window scatter over the image; none by default."""
    diffraction: Diffraction | None = None
    """By the aperture, beside `blur_px`; none by default: 0.1 px in most cameras."""
    faults: PixelFaults = PixelFaults()
    """Dark signals, hot and dead pixels, offsets of rows; none by default."""
    dust: Dust | None = None
    """On the window; none by default."""
    compression: Compression | None = None
    """Compression of the stream: frames are stored and judged as they come out of it; none by default."""

    def _problems(self) -> Iterator[str | None]:
        if any(
            abs(offset) > size / 2
            for offset, size in zip(self.principal_offset_px, (self.columns, self.rows), strict=True)
        ):
            yield (
                f"principal_offset_px = {list(self.principal_offset_px)} is not allowed: must lie in the image of "
                f"{self.columns} x {self.rows} pixels, counted from its centre"
            )
        faults = {f"faults.{name}": getattr(self.faults, name) for name in ("dark_e", "row_e")}
        for name, noise in ({"read_noise_e": self.read_noise_e} | faults).items():
            if noise > self.full_well_e:
                yield f"{name} = {noise:g} is not allowed: must be at most full_well_e = {self.full_well_e:g}"
        if isinstance(self.compression, H264) and (self.columns % 2 or self.rows % 2):
            yield f"compression.kind = 'h264' is not allowed with {self.columns} x {self.rows} pixels: must be even"
        if self.region_px is not None:
            column, row, columns, rows = self.region_px
            if column + columns > self.columns or row + rows > self.rows:
                yield (
                    f"region_px = {list(self.region_px)} is not allowed: must lie in the image of {self.columns} x "
                    f"{self.rows} pixels"
                )
            used = [name for name, off in WHOLE_IMAGE.items() if getattr(self, name) != off]
            if used or self.shutter.moves:
                yield f"region_px is not allowed with {(used or ['shutter.moves'])[0]}: it needs the whole image"

    @property
    def window(self) -> Window:
        """What is read out."""
        if self.region_px is None:
            return Window.whole(self.columns, self.rows)
        column, row, columns, rows = self.region_px
        return Window(column=column, row=row, columns=columns, rows=rows)

    def pixelwise(self) -> Self:
        """Without what needs the whole image or the frames before, so that parts of single images can be read out."""
        still = {"shutter": self.shutter.model_copy(update={"moves": False})}
        return self.model_copy(update=WHOLE_IMAGE | still)

    @property
    def history(self) -> tuple[str, ...]:
        """Why frames depend on those before, in words; empty where they do not."""
        reasons = {
            "camera.live: gains follow": self.live is not None,
            "camera.shutter.moves: rows lie between frames": self.shutter.moves,
            "camera.compression: H.264 predicts from earlier frames": isinstance(self.compression, H264),
        }
        return tuple(reason for reason, holds in reasons.items() if holds)
