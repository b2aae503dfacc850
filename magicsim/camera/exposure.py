"""From linear radiance to the 8-bit frame: exposure, noise, tone curve, compression; each frame by itself.

Noise follows the linear camera model of EMVA Standard 1288: photo-electrons (Poisson's law, taken as a
Gaussian of its variance), Gaussian read noise, a fixed gain pattern, dark signals. Exposure is measured once on the
untouched sensor; `magicsim.camera.stream` has what depends on time and on the frames before.

Frames as compression leaves them: JPEG one by one, H.264 as a stream, which needs PyAV, the extra `video`.
"""

from fractions import Fraction
from typing import Any

import cv2
import numpy as np

from magicsim.arrays import Array, FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.disturbances import (
    PATTERN_STREAM,
    dark_signal_e,
    deviates,
    is_alive,
    row_offsets_e,
    shift_px,
    shifted,
)
from magicsim.camera.effect_settings import H264, Mjpeg, PixelFaults
from magicsim.errors import ConfigError, RenderError

LOW_DELAY = 0x80000
"""FFmpeg's flag of a decoder that gives each frame at once."""


class VideoCodec:
    """Coder and decoder of one stream, each in one thread: the same frames give the same bytes."""

    def __init__(self, h264: H264, *, rows: int, columns: int, frames_per_second: float) -> None:
        """Opens both; `ConfigError` where PyAV is missing."""
        av = _pyav()
        coder = av.CodecContext.create("libx264", "w")
        coder.width, coder.height, coder.pix_fmt = columns, rows, "yuv420p"
        coder.time_base = 1 / Fraction(frames_per_second).limit_denominator(1000)
        coder.gop_size, coder.thread_count = h264.keyframe_frames, 1
        coder.options = {"crf": str(h264.crf), "preset": "veryfast", "tune": "zerolatency", "threads": "1"}
        decoder = av.CodecContext.create("h264", "r")
        decoder.thread_count = 1
        decoder.flags |= LOW_DELAY
        self._video_frame, self._coder, self._decoder, self._count = av.VideoFrame, coder, decoder, 0

    def through(self, frame: Frame) -> Frame:
        """The next frame of the stream, compressed and decompressed; RGB, shape (rows, columns, 3)."""
        picture = self._video_frame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
        picture.pts, self._count = self._count, self._count + 1
        found = [each for packet in self._coder.encode(picture) for each in self._decoder.decode(packet)]
        return np.asarray(found[-1].to_ndarray(format="rgb24"), np.uint8)


def check_codec(compression: H264 | Mjpeg | None) -> None:
    """Refuses (`ConfigError`) a video that cannot be coded here, before anything is rendered for it."""
    if isinstance(compression, H264):
        _pyav()


def _pyav() -> Any:  # noqa: ANN401 - PyAV is optional
    try:
        import av
    except ModuleNotFoundError:
        raise ConfigError("camera.compression.kind = 'h264' needs PyAV; `pip install magicsim[video]`") from None
    return av


def through_mjpeg(frame: Frame, mjpeg: Mjpeg) -> Frame:
    """The frame compressed and decompressed."""
    chroma = getattr(cv2, f"IMWRITE_JPEG_SAMPLING_FACTOR_{mjpeg.chroma}")
    options = [cv2.IMWRITE_JPEG_QUALITY, mjpeg.quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, chroma]
    packed = cv2.imencode(".jpg", np.ascontiguousarray(frame[..., ::-1]), options)[1]
    unpacked = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
    return np.ascontiguousarray(unpacked[..., ::-1])


Lit = tuple[bool, bool, bool]
NO_FAULTS = PixelFaults()


def meter(untouched: FloatImage, camera: Camera, lit: Lit = (True, True, True)) -> Array:
    """Auto-exposure: the gain of each channel that brings the untouched sensor to the camera's mean grey level.

    Signal = gain * radiance, 1 at grey level 255; shape (3,).

    A channel in which no light shines is exposed like the others. Where no light arrives at all nothing can be
    measured: a radiance of 1 then comes to the grey level that is aimed at.

    Raises:
        RenderError: A channel is dark though light shines in it and others are not, or the image is not finite.
    """
    aim = aimed_signal(camera)
    mean = sensed(untouched, camera).mean((0, 1), dtype=np.float64)
    if not mean.any():
        return np.full(3, aim)
    seen = np.abs(np.array(camera.color_matrix)) @ np.array(lit) > 0
    if not camera.white_balance:
        mean = np.full(3, mean.mean())
    elif seen.any():
        mean = np.where(seen, mean, mean[seen].mean())
    if not (mean > 0).all() or not np.isfinite(mean).all():
        raise RenderError(
            f"auto-exposure fails: mean radiance of the untouched sensor is {mean.round(6).tolist()} (RGB), "
            "each channel must be above 0; light reaches the camera only through scattering "
            "(materials.infill.sigma_s_per_mm)"
        )
    return np.asarray(aim / mean)


def aimed_signal(camera: Camera) -> float:
    """Mean signal of the untouched frame that auto-exposure aims at, 1 at grey level 255."""
    return float((camera.exposure_grey / 255) ** camera.gamma)


def expose(
    radiance: FloatImage, gain: Array, camera: Camera, *, seed: int, frame: int, base: Array | None = None
) -> Frame:
    """Takes one 8-bit frame, RGB of shape (rows, columns, 3); `RenderError` where the radiance is not finite.

    Args:
        radiance: Linear radiance of what the camera reads out, shape (rows, columns, 3).
        gain: Gain of each channel in this frame, shape (3,).
        camera: Noise, tone curve and compression; one in which frames depend on each other is left out.
        seed: Seed of the episode.
        frame: Number of the frame in the stream, references included; each has noise of its own.
        base: Gains at which `full_well_e` counts; those of this frame by default. A gain twice as high shows half as
            many electrons as white.
    """
    bad = int(np.count_nonzero(~np.isfinite(radiance)))
    if bad:
        msg = f"frame {frame} of seed {seed} is not rendered: its image holds {bad} values that are not finite"
        raise RenderError(msg)
    light = radiance
    if camera.vibration_px > 0:
        light = shifted(radiance, shift_px(camera.vibration_px, seed=seed, frame=frame))
    pattern = 1 + camera.fixed_pattern * _noise(radiance.shape, camera, deviates(camera.pattern_seed, PATTERN_STREAM))
    signal = np.clip(sensed(light, camera) * gain, 0, 4) * pattern
    well = camera.full_well_e if base is None else camera.full_well_e * base / gain
    electrons = np.clip(signal, 0, None) * well
    if camera.faults.dead_share > 0:
        electrons *= camera.window.of(is_alive(camera))
    # Above some hundred electrons the Poisson law is Gaussian to well below one grey level, and twenty times faster.
    noisy = electrons + np.sqrt(electrons + camera.read_noise_e**2) * _noise(
        radiance.shape, camera, deviates(seed, frame)
    )
    if camera.faults != NO_FAULTS:
        rows = row_offsets_e(camera.faults, rows=camera.rows, seed=seed, frame=frame)
        noisy += camera.window.of(dark_signal_e(camera) + rows)
    tone = np.clip(noisy / well, 0, 1) ** (1 / camera.gamma)
    image = np.rint(255 * tone).astype(np.uint8)
    return through_mjpeg(image, camera.compression) if isinstance(camera.compression, Mjpeg) else image


def _noise(shape: tuple[int, ...], camera: Camera, random: np.random.Generator) -> Array:
    """Normal deviates of the pixels that are read out, each its own in the whole image."""
    if camera.region_px is None:
        return random.standard_normal(shape)
    return np.asarray(camera.window.of(random.standard_normal((camera.rows, camera.columns, 3))))


def sensed(radiance: FloatImage, camera: Camera) -> FloatImage:
    """What the sensor's own colours see of linear RGB, shape (rows, columns, 3)."""
    matrix = np.array(camera.color_matrix, np.float32)
    return radiance if (matrix == np.eye(3)).all() else radiance @ matrix.T
