"""Effects of a real camera, each a table of its own below `rig.camera`; left out, an effect is off.

All are off by default, because the default rig's figures were measured without them; `scenes/rigs/digit-webcam.toml`
has all that an ordinary webcam shows. Noise of photons and reading and the gain pattern, which are always on, are
fields of `Camera` (`magicsim.camera.camera`). Ranges are *assumed* unless a source is named.
"""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config

Share = Annotated[float, Field(ge=0, le=1)]
Electrons = Annotated[float, Field(ge=0, le=1e12)]
Frames = Annotated[float, Field(ge=0.1, le=10_000)]


class LiveExposure(Config):
    """Exposure and white balance that follow what the camera sees, instead of those locked on the untouched sensor.

    Gain follows, exposure time stays, as in a driver's mode that avoids flicker: noise grows with the gain.
    """

    exposure: bool = True
    """Whether the gain of all channels follows the mean brightness."""
    white_balance: bool = True
    """Whether the gains of the channels follow their means ("grey world")."""
    metering: Literal["mean", "centre"] = "mean"
    """Mean of the whole image, or weighted by a Gaussian around its centre, whose deviation is a quarter of each
    side."""
    time_constant_frames: Frames = 5.0
    """Frames in which the error of exposure falls to 1/e; assumed, 2 to 15: webcams settle within about a second."""
    white_balance_frames: Frames = 25.0
    """Frames in which that of white balance does; assumed, 10 to 100: it is slower than exposure, so that the two do
    not swing."""
    delay_frames: Annotated[int, Field(ge=0, le=8)] = 1
    """Frames that a new gain takes to arrive; assumed, 1 to 2: registers of image sensors work on the next frame."""
    gain_limits: tuple[Annotated[float, Field(ge=1e-3, le=1)], Annotated[float, Field(ge=1, le=1e3)]] = (0.25, 8.0)
    """Least and largest gain in units of what the untouched sensor was metered at; assumed."""
    tolerance: Annotated[float, Field(ge=0, le=0.5)] = 0.02
    """Relative error of brightness or of a channel that is left as it is, which keeps the gain from hunting; assumed, 0
    to 0.1."""

    def _problems(self) -> Iterator[str | None]:
        least = least_frames(self.delay_frames)
        for name in ("time_constant_frames", "white_balance_frames"):
            value = getattr(self, name)
            if value <= least:
                yield (
                    f"{name} = {value:g} is not allowed with delay_frames = {self.delay_frames}: exposure would swing "
                    f"and never settle; must be above {least:.3g}"
                )


class Shutter(Config):
    """When the rows of a frame collect light. A frame's time is the end of its last row."""

    exposure_ms: Annotated[float, Field(gt=0, le=10_000)] = 20.0
    """How long a row collects light [ms], at most from frame to frame; assumed, 2 to 33: multiples of 10 ms hide the
    flicker of 50 Hz mains."""
    row_us: Annotated[float, Field(ge=0, le=100_000)] = 0.0
    """Time from one row to the next [us]; 0 is a global shutter. Assumed, 10 to 100 for 320 rows: a rolling shutter
    reads over most of a frame."""
    moves: bool = False
    """Whether rows show what lies between the frame before and this one, linearly mixed by the middle of their
    exposure: right for what moves by less than a pixel or so in a frame, two faint images of what moves further."""


class Flicker(Config):
    """Light of the room that swings at twice the mains frequency; LED strips and flashlight run on direct current."""

    mains_hz: Annotated[float, Field(ge=1, le=1000)] = 50.0
    """Frequency of the mains [Hz], 50 or 60; it wanders by some hundredths."""
    depth: Share = 0.1
    """Half the swing over the mean (IEEE Std 1789-2015, "percent flicker"): 0.07 incandescent, 0.02 to 0.4 LED and
    fluorescent lamps, 0 daylight."""


class LedDrift(Config):
    """Slow wander of the strength of the LEDs, which temperature and supply cause; each colour by itself."""

    share: Annotated[float, Field(ge=0, le=0.2)] = 0.003
    """Relative standard deviation; assumed, 0.001 to 0.01: LEDs lose 0.2 (blue) to 1 % (red) of light per kelvin."""
    time_s: Annotated[float, Field(ge=0.1, le=1e5)] = 30.0
    """Correlation time [s]; assumed, 5 to 300: that of a small board's temperature."""


class Glare(Config):
    """Veiling glare: light that surfaces of lens and window scatter widely (ISO 9358 measures it)."""

    share: Annotated[float, Field(ge=0, le=0.9)] = 0.02
    """Part of all light; assumed, 0.01 to 0.1: small uncoated lenses are at the upper end."""
    radius_px: Annotated[float, Field(ge=1, le=2000)] = 40.0
    """Standard deviation of the Gaussian that it is spread by [px]; assumed."""


class Diffraction(Config):
    """Blur by the lens' aperture: the Airy pattern of each channel's wavelength."""

    f_number: Annotated[float, Field(ge=0.5, le=64)] = 2.8
    """Focal length over aperture; assumed, 2 to 3 in webcams."""
    pixel_um: Annotated[float, Field(ge=0.3, le=100)] = 3.5
    """Pitch of the pixels that are read out [um]; assumed, 1.75 (OVM7692, DIGIT's sensor, at 640 x 480) to 6."""
    wavelengths_nm: tuple[Annotated[float, Field(ge=300, le=1100)], ...] = Field(
        default=(625.0, 530.0, 470.0), min_length=3, max_length=3
    )
    """Wavelengths of red, green and blue [nm]; those of DIGIT's LEDs."""


class PixelFaults(Config):
    """How pixels and rows differ, beside their gains. The pattern belongs to the camera (`pattern_seed`)."""

    dark_e: Electrons = 0.0
    """Standard deviation of the pixels' dark signals (EMVA 1288, DSNU) [electrons]; assumed, 1 to 20 a pixel."""
    row_e: Electrons = 0.0
    """Standard deviation of the offset that a whole row has in a frame [electrons]; assumed, a tenth of the read noise
    to all of it: the eye sees it from a tenth on."""
    hot_share: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    """Part of all pixels whose dark signal is far too high; assumed, 0 to 1e-3: drivers correct most."""
    hot_e: Electrons = 0.0
    """Mean of their dark signals, exponentially distributed [electrons]."""
    dead_share: Annotated[float, Field(ge=0, le=0.1)] = 0.0
    """Part of all pixels that see no light; assumed, 0 to 1e-4."""


class Dust(Config):
    """Specks on the window: soft dark spots that stay where they are. `pattern_seed` places them."""

    specks: Annotated[int, Field(ge=0, le=10_000)] = 12
    """Number in the whole image; assumed, 0 to 50."""
    radius_px: Annotated[float, Field(ge=0.3, le=500)] = 4.0
    """Median radius [px]; radii are lognormal with a deviation of 0.5. Assumed, 1 to 10."""
    opacity: Share = 0.15
    """Largest part of the light that a speck takes; assumed, 0.05 to 0.5. Each takes an even draw up to it."""


class Mjpeg(Config):
    """Each frame compressed by itself, as most webcams send it."""

    kind: Literal["mjpeg"]
    quality: Annotated[int, Field(ge=1, le=100)] = 85
    """JPEG quality of libjpeg; assumed, 70 to 95."""
    chroma: Literal["444", "422", "420"] = "422"
    """Sampling of the colours; webcams' 4:2:2 halves them along rows."""


class H264(Config):
    """A video stream, in which frames depend on those before; needs PyAV, `pip install magicsim[video]`."""

    kind: Literal["h264"]
    crf: Annotated[int, Field(ge=0, le=51)] = 23
    """x264's constant rate factor: 0 loses nothing but colour detail, 51 is worst."""
    keyframe_frames: Annotated[int, Field(ge=1, le=10_000)] = 30
    """Frames from one that stands alone to the next."""


Compression = Annotated[Mjpeg | H264, Field(discriminator="kind")]


def correction_share(time_constant_frames: float) -> float:
    """Part of the error that is corrected in a frame, so that it falls to 1/e in so many frames."""
    return -math.expm1(-1 / time_constant_frames)


def largest_share(delay_frames: int) -> float:
    """The bound of what may be corrected in a frame.

    The relative error e of a brightness whose logarithm is corrected by a share a of the error seen d frames ago
    follows e(k + 1) = e(k) - a e(k - d). It decays where 0 < a < 2 cos(pi d / (2 d + 1)) (Levin and May, *Theor. Popul.
    Biol.* 9, 178, 1976).
    """
    return 2 * math.cos(math.pi * delay_frames / (2 * delay_frames + 1))


def least_frames(delay_frames: int) -> float:
    """The bound of the time constant [frames]; 0 where any settles."""
    largest = largest_share(delay_frames)
    return -1 / math.log1p(-largest) if largest < 1 else 0.0
