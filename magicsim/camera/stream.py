"""A camera that films: frames in order, each with the light of its time and with what it inherits from those before.

What a frame depends on is the light of all frames up to it, and never what was made of them: a state that returns is
another frame. All functions are pure, so that a stream may be taken up at any frame whose memory is kept.

Gains that follow what the camera sees.

Each frame the logarithms of the gains are corrected by a share of the errors of brightness and of the channels'
balance, metered in the linear signal that is clipped at white; a new gain arrives some frames later.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.disturbances import between_frames, flicker_share, led_drift, readout_problem
from magicsim.camera.effect_settings import H264, LiveExposure, correction_share
from magicsim.camera.exposure import Lit, VideoCodec, aimed_signal, expose, meter, sensed
from magicsim.errors import RenderError

FAINTEST = 1e-6
"""Least signal that is metered: a black image asks for a large gain and not for an infinite one."""
MAX_SETTLING = 2000
"""Frames after which a camera that still corrects its gains is taken to have no balance."""
SETTLED = 1e-6
"""Largest correction of a settled gain."""
SETTLING_FRAMES = 50.0
"""Longest time constant with which the settled gains are looked for: they do not depend on it."""
CENTRE_SHARE = 0.25
"""Deviation of the centre's weights over each side."""


def metered(sensed: FloatImage, gain: Array, metering: str) -> Array:
    """Mean signal of each channel, clipped at white, shape (3,)."""
    signal = np.clip(sensed * gain, 0, 1)
    if metering == "mean":
        return np.asarray(signal.mean((0, 1), dtype=np.float64))
    down, across = (np.exp(-((np.linspace(-1, 1, count) / (2 * CENTRE_SHARE)) ** 2) / 2) for count in sensed.shape[:2])
    return np.asarray(np.einsum("r,c,rcx->x", down / down.sum(), across / across.sum(), signal, dtype=np.float64))


def corrected(gain: Array, means: Array, live: LiveExposure, *, aim: float, first: Array) -> Array:
    """The gains that a frame's metered signals ask for, shape (3,), within limits relative to `first`."""
    seen = np.maximum(means, FAINTEST)
    step = np.zeros(3)
    if live.exposure:
        step += correction_share(live.time_constant_frames) * _beyond(np.log(aim / seen.mean()), live.tolerance)
    if live.white_balance:
        is_seen = means > FAINTEST  # a colour without light has no balance
        balance = np.where(is_seen, np.log(seen.mean() / seen), 0.0)
        balance -= is_seen * balance.sum() / max(1, is_seen.sum())
        step += correction_share(live.white_balance_frames) * _beyond(balance, live.tolerance)
    return np.asarray(np.clip(gain * np.exp(step), first * live.gain_limits[0], first * live.gain_limits[1]))


def settled(sensed: FloatImage, live: LiveExposure, *, aim: float, first: Array) -> Array:
    """Gains at which the untouched sensor stays, shape (3,).

    Where no light arrives at all they are the first ones.

    `RenderError` where it never settles, or not at what it aims at. Exposure begins at the first gains, which limits
    are relative to.
    """
    if not sensed.any():
        return first
    names = ("time_constant_frames", "white_balance_frames")
    quick = {name: min(getattr(live, name), SETTLING_FRAMES) for name in names}
    exact, gain = live.model_copy(update={"tolerance": 0.0} | quick), first
    for _ in range(MAX_SETTLING):
        means = metered(sensed, gain, live.metering)
        chosen = corrected(gain, means, exact, aim=aim, first=first)
        if np.abs(chosen / gain - 1).max() < SETTLED:
            break
        gain = chosen
    else:
        msg = f"live exposure never settles on the untouched sensor: gains still move after {MAX_SETTLING} frames"
        raise RenderError(msg)
    reached = float(means.mean())
    if live.exposure and abs(np.log(max(reached, FAINTEST) / aim)) > max(live.tolerance, 100 * SETTLED):
        raise RenderError(
            f"live exposure never settles on the untouched sensor: its mean signal is {reached:.3g} of white at the "
            f"limit of the gains (camera.live.gain_limits = {list(live.gain_limits)}), {aim:.3g} is aimed at "
            "(camera.exposure_grey)"
        )
    return gain


def _beyond(error: Array | float, tolerance: float) -> Array:
    """An error where it is worth correcting."""
    return np.where(np.abs(error) > tolerance, error, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Instant:
    """Which frame of which stream."""

    seed: int
    """Seed of the stream's noise."""
    index: int
    """Place in the stream, reference frames included."""
    time_s: float
    """Time since the stream began [s]."""
    frames_per_second: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraMemory:
    """What a frame inherits from those before it."""

    gains: tuple[Array, ...]
    """Signal = gain * what the sensor's colours see: gain of each channel in the frame, shape (3,), and those that are
    chosen already for the frames after it, the next one first."""
    before: FloatImage | None = None
    """Radiance of the frame before, where rows lie between frames."""
    video: VideoCodec | None = None
    """The coded stream; it goes on by itself, so each frame must be taken once and in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraStream:
    """The camera of one sensor, ready to film."""

    camera: Camera
    gain: Array
    """Gain of each channel on the untouched sensor, locked, or where live exposure has settled; shape (3,)."""
    room: FloatImage | None
    """What the room's light makes of the untouched image, shape (rows, columns, 3); None where that is not needed."""

    @classmethod
    def of(
        cls, camera: Camera, untouched: FloatImage, lit: Lit = (True, True, True), *, room: FloatImage | None = None
    ) -> Self:
        """A camera as exposed on the untouched sensor, with the part of its light that the room brings.

        `RenderError` where exposure fails or never settles.
        """
        gain = meter(untouched, camera, lit)
        if camera.live is not None:
            gain = settled(sensed(untouched, camera), camera.live, aim=aimed_signal(camera), first=gain)
        return cls(camera=camera, gain=gain, room=room)

    def begin(self, frames_per_second: float) -> CameraMemory:
        """What the first frame inherits: a camera that has looked at the untouched sensor for long.

        `ConfigError` where PyAV is missing, and the stream is to be H.264.
        """
        camera, video = self.camera, None
        if isinstance(camera.compression, H264):
            video = VideoCodec(
                camera.compression, rows=camera.rows, columns=camera.columns, frames_per_second=frames_per_second
            )
        return CameraMemory(gains=(self.gain,), video=video)

    def take(self, radiance: FloatImage, memory: CameraMemory, at: Instant) -> tuple[Frame, CameraMemory]:
        """One frame, and what the next one inherits.

        `RenderError` where the radiance is not finite, or the rows take longer than a frame.
        """
        light = self._light(radiance, memory, at)
        base = self.gain if self.camera.live is not None else None
        image = expose(light, memory.gains[0], self.camera, seed=at.seed, frame=at.index, base=base)
        if memory.video is not None:
            image = memory.video.through(image)
        return image, self._after(radiance, light, memory)

    def passed(self, radiance: FloatImage, memory: CameraMemory, at: Instant) -> CameraMemory:
        """What the next frame inherits of one that is not looked at; arguments as `take`."""
        if not self.camera.history:
            return memory
        if memory.video is not None:
            return self.take(radiance, memory, at)[1]
        return self._after(radiance, self._light(radiance, memory, at), memory)

    def _light(self, radiance: FloatImage, memory: CameraMemory, at: Instant) -> FloatImage:
        """Light of the frame as it swings, wanders and moves, shape (rows, columns, 3)."""
        camera, light = self.camera, radiance
        rate, time_s = at.frames_per_second, round(at.time_s, 6)  # microseconds, however the time was summed up
        if problem := readout_problem(camera.shutter, rows=camera.rows, frames_per_second=rate):
            raise RenderError(problem)
        if camera.shutter.moves and memory.before is not None and memory.before.shape == radiance.shape:
            light = between_frames(memory.before, radiance, camera.shutter, frames_per_second=rate)
        if camera.led_drift is None and (camera.flicker is None or self.room is None):
            return light
        room = np.zeros_like(light) if self.room is None else np.minimum(self.room, light)
        change: npt.NDArray[np.float64] = np.zeros(light.shape)
        if camera.led_drift is not None:
            change += led_drift(camera.led_drift, time_s=time_s, seed=at.seed) * (light - room)
        if camera.flicker is not None:
            rows = flicker_share(
                camera.flicker, camera.shutter, rows=camera.rows, time_s=time_s, frames_per_second=rate, seed=at.seed
            )
            first = camera.window.row
            change += rows[first : first + len(room), None, None] * room
        return np.asarray(np.maximum(light + change, 0), np.float32)

    def _after(self, radiance: FloatImage, light: FloatImage, memory: CameraMemory) -> CameraMemory:
        camera, gains = self.camera, memory.gains
        if camera.live is not None:
            means = metered(sensed(light, camera), gains[0], camera.live.metering)
            chosen = corrected(gains[-1], means, camera.live, aim=aimed_signal(camera), first=self.gain)
            gains = (*gains, chosen)[-1 - camera.live.delay_frames :]
        return CameraMemory(gains=gains, before=radiance if camera.shutter.moves else None, video=memory.video)
