"""What disturbs a camera: faults of pixels and rows, dust, shaking, a rolling shutter, flicker, and drift of the LEDs.

Each thing that varies has a generator of its own, found by seed and place alone.
"""

from functools import lru_cache

import cv2
import numpy as np

from magicsim.arrays import Array, FloatImage, Mask
from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import Dust, Flicker, LedDrift, PixelFaults, Shutter

SPREAD = 0.5
"""Standard deviation of the logarithm of the radii; assumed."""
ROUNDING = 1e-9
"""Rounding of the products of times and rates."""
WAVES = 64
"""Cosines in the sum."""
PATTERN_STREAM = 2**31
"""Streams from here on are beyond every frame's. This one: what belongs to the camera."""
DRIFT_STREAM = PATTERN_STREAM + 1
"""Wander of the LEDs of an episode."""
PHASE_STREAM = PATTERN_STREAM + 2
"""Where in its swing the mains light begins."""
ROWS, SHAKE = 1, 2
"""Parts of a frame's stream, beside its pixels' noise."""
DARK, HOT, DEAD, DUST = 1, 2, 3, 4
"""Parts of the pattern, beside the pixels' gains."""


def deviates(seed: int, stream: int, part: int = 0) -> np.random.Generator:
    """The generator of one thing by the seed of an episode or pattern, a frame or stream above, and a part of it."""
    words = [seed, stream, part] if part else [seed, stream]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))


@lru_cache(maxsize=4)
def dark_signal_e(camera: Camera) -> Array:
    """Dark signal of each pixel about the mean that the driver takes off, shape (rows, columns, 3) [electrons]."""
    shape, faults = (camera.rows, camera.columns, 3), camera.faults
    dark = faults.dark_e * deviates(camera.pattern_seed, PATTERN_STREAM, DARK).standard_normal(shape)
    random = deviates(camera.pattern_seed, PATTERN_STREAM, HOT)
    is_hot = random.random(shape) < faults.hot_share
    return np.asarray(dark + is_hot * faults.hot_e * random.standard_exponential(shape))


@lru_cache(maxsize=4)
def is_alive(camera: Camera) -> Mask:
    """Which pixels see light, shape (rows, columns, 3)."""
    random = deviates(camera.pattern_seed, PATTERN_STREAM, DEAD)
    return np.asarray(random.random((camera.rows, camera.columns, 3)) >= camera.faults.dead_share)


def row_offsets_e(faults: PixelFaults, *, rows: int, seed: int, frame: int) -> Array:
    """Offset of each row in a frame, shape (rows, 1, 1) [electrons]."""
    return np.asarray(faults.row_e * deviates(seed, frame, ROWS).standard_normal((rows, 1, 1)))


def transmittance(dust: Dust, *, rows: int, columns: int, pattern_seed: int) -> Array:
    """Part of the light that passes to each pixel, shape (rows, columns).

    A speck of radius r and opacity a takes a exp(-2 d^2 / r^2) at a distance d from its middle; a pi r^2 / 2 pixels in
    all.
    """
    random = deviates(pattern_seed, PATTERN_STREAM, DUST)
    places = random.random((dust.specks, 2)) * (rows, columns) - 0.5
    radii = dust.radius_px * np.exp(SPREAD * random.standard_normal(dust.specks))
    taken = dust.opacity * random.random(dust.specks)
    passes = np.ones((rows, columns))
    down, across = np.arange(rows), np.arange(columns)
    for (row, column), radius, opacity in zip(places, radii, taken, strict=True):
        along = np.exp(-2 * ((down - row) / radius) ** 2)
        passes *= 1 - opacity * along[:, None] * np.exp(-2 * ((across - column) / radius) ** 2)
    return passes


def shift_px(vibration_px: float, *, seed: int, frame: int) -> Array:
    """Shift of an image by a mount that shakes, down and right, shape (2,) [px].

    Frames are independent, as of a motion faster than the frame rate.
    """
    return np.asarray(vibration_px * deviates(seed, frame, SHAKE).standard_normal(2))


def shifted(image: FloatImage, by_px: Array) -> FloatImage:
    """The image moved down and right by parts of a pixel; its mirror comes in from beyond the border."""
    down, across = (_taps(float(each)) for each in by_px)
    return np.asarray(cv2.sepFilter2D(image, -1, across, down, borderType=cv2.BORDER_REFLECT_101), np.float32)


def _taps(by_px: float) -> Array:
    """Weights of the pixels around one, for what lies so far before it.

    Cubic convolution with a = -1/2 (Keys, *IEEE Trans. ASSP* 29, 1153, 1981).
    """
    reach = int(abs(by_px)) + 2
    away = np.abs(np.arange(-reach, reach + 1) + by_px)
    near = (1.5 * away - 2.5) * away**2 + 1
    far = ((-0.5 * away + 2.5) * away - 4) * away + 2
    return np.where(away <= 1, near, np.where(away < 2, far, 0.0))  # noqa: PLR2004 - pieces of the polynomial


def row_ends_s(shutter: Shutter, *, rows: int, time_s: float) -> Array:
    """End of the exposure of each row, shape (rows,) [s]: the last one's is the frame's time."""
    return np.asarray(time_s - 1e-6 * shutter.row_us * np.arange(rows - 1, -1, -1))


def exposure_s(shutter: Shutter, frames_per_second: float) -> float:
    """How long a row collects light: never longer than from frame to frame [s]."""
    return min(shutter.exposure_ms / 1000, 1 / frames_per_second)


def between_frames(before: FloatImage, now: FloatImage, shutter: Shutter, *, frames_per_second: float) -> FloatImage:
    """What rows see of two states, one frame apart, linear between them; shape (rows, columns, 3)."""
    middle_s = row_ends_s(shutter, rows=len(now), time_s=0.0) - exposure_s(shutter, frames_per_second) / 2
    share = np.clip(1 + frames_per_second * middle_s, 0, 1)[:, None, None]
    return np.asarray(before + share * (now - before), np.float32)


def readout_problem(shutter: Shutter, *, rows: int, frames_per_second: float) -> str | None:
    """What is wrong with a shutter that does not read the rows before the next frame's."""
    if 1e-6 * shutter.row_us * rows * frames_per_second <= 1 + ROUNDING:
        return None
    return (
        f"camera.shutter.row_us = {shutter.row_us:g} is not allowed: {rows} rows are read in "
        f"{1e-3 * shutter.row_us * rows:.3g} ms, which must be at most the {1000 / frames_per_second:.3g} ms between "
        "frames"
    )


def flicker_share(
    flicker: Flicker, shutter: Shutter, *, rows: int, time_s: float, frames_per_second: float, seed: int
) -> Array:
    """By how much of its mean the room's light exceeds it in each row of a rolling shutter, shape (rows,).

    Light 1 + m cos(2 pi f t + p) with f twice the mains frequency, averaged over an exposure of length T that ends at
    t, is 1 + m sinc(f T) cos(2 pi f (t - T / 2) + p), sinc(x) = sin(pi x) / (pi x).
    """
    frequency, open_s = 2 * flicker.mains_hz, exposure_s(shutter, frames_per_second)
    phase = 2 * np.pi * deviates(seed, PHASE_STREAM).random()
    middle = row_ends_s(shutter, rows=rows, time_s=time_s) - open_s / 2
    size = flicker.depth * np.sinc(frequency * open_s)
    return np.asarray(size * np.cos(2 * np.pi * frequency * middle + phase))


def led_drift(drift: LedDrift, *, time_s: float, seed: int) -> Array:
    """Relative change of the LEDs' red, green and blue, shape (3,), known at any time without those before.

    A slow wander with a correlation that falls as exp(-t / T): a sum of cosines whose frequencies follow the spectrum,
    a Cauchy distribution of width 1 / T (Shinozuka and Deodatis, *Appl. Mech. Rev.* 44, 191, 1991).
    """
    random = deviates(seed, DRIFT_STREAM)
    frequency = random.standard_cauchy((WAVES, 3)) / drift.time_s
    phase = 2 * np.pi * random.random((WAVES, 3))
    return np.asarray(drift.share * np.sqrt(2 / WAVES) * np.cos(frequency * time_s + phase).sum(0))
