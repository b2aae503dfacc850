"""A camera that films: frames in order, each with the light of its time and with what it inherits from those before.

What a frame depends on is the light of all frames up to it, and never what was made of them: a state that returns is
another frame. All functions are pure, so that a stream may be taken up at any frame whose memory is kept.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import FloatImage, Frame
from magicsim.camera.camera import Camera
from magicsim.camera.codecs import VideoCodec
from magicsim.camera.disturbances import between_frames, flicker_share, led_drift, readout_fits, readout_problem
from magicsim.camera.effect_settings import H264
from magicsim.camera.exposure import Exposure, Lit, aimed_signal, expose, meter, sensed
from magicsim.camera.live_exposure import Gains, corrected, metered, settled
from magicsim.errors import RenderError


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
    """Frame rate [1/s]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraMemory:
    """What a frame inherits from those before it."""

    gains: Gains
    """Gains of the frame, and those that will follow."""
    before: FloatImage | None = None
    """Radiance of the frame before, where rows lie between frames."""
    video: VideoCodec | None = None
    """The coded stream; it goes on by itself, so each frame must be taken once and in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraStream:
    """The camera of one sensor, ready to film."""

    camera: Camera
    """Settings of the camera."""
    exposure: Exposure
    """Gains on the untouched sensor: locked, or where live exposure has settled."""
    room: FloatImage | None
    """What the room's light makes of the untouched image, shape (rows, columns, 3); None where that is not needed."""

    @classmethod
    def of(
        cls, camera: Camera, untouched: FloatImage, lit: Lit = (True, True, True), *, room: FloatImage | None = None
    ) -> Self:
        """A camera as exposed on the untouched sensor.

        Args:
            camera: Which one.
            untouched: Linear radiance of the whole sensor at rest, shape (rows, columns, 3).
            lit: Whether any light shines in red, green and blue, see `Rig.lit`.
            room: Part of it that comes from the room's light, in what is read out, shape (rows, columns, 3).

        Raises:
            RenderError: Exposure fails or never settles.
        """
        exposure = meter(untouched, camera, lit)
        if camera.live is not None:
            gain = settled(sensed(untouched, camera), camera.live, aim=aimed_signal(camera), first=exposure.gain)
            exposure = Exposure(gain=gain)
        return cls(camera=camera, exposure=exposure, room=room)

    def begin(self, frames_per_second: float) -> CameraMemory:
        """What the first frame inherits: a camera that has looked at the untouched sensor for long.

        Raises:
            ConfigError: PyAV is missing, and the stream is to be H.264.
        """
        camera, video = self.camera, None
        if isinstance(camera.compression, H264):
            video = VideoCodec(
                camera.compression, rows=camera.rows, columns=camera.columns, frames_per_second=frames_per_second
            )
        return CameraMemory(gains=Gains(now=self.exposure.gain), video=video)

    def take(self, radiance: FloatImage, memory: CameraMemory, at: Instant) -> tuple[Frame, CameraMemory]:
        """One frame, and what the next one inherits.

        Args:
            radiance: What the camera would read out of steady light, linear, shape (rows, columns, 3).
            memory: From the frame before, or `begin`.
            at: Which frame it is.

        Raises:
            RenderError: The radiance is not finite, or the rows take longer than a frame.
        """
        light = self._light(radiance, memory, at)
        gain = Exposure(gain=memory.gains.now)
        base = self.exposure if self.camera.live is not None else None
        image = expose(light, gain, self.camera, seed=at.seed, frame=at.index, base=base)
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
        if not readout_fits(camera.shutter, rows=camera.rows, frames_per_second=rate):
            raise RenderError(readout_problem(camera.shutter, rows=camera.rows, frames_per_second=rate))
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
            means = metered(sensed(light, camera), gains.now, camera.live.metering)
            chosen = corrected(gains.latest, means, camera.live, aim=aimed_signal(camera), first=self.exposure.gain)
            gains = gains.followed_by(chosen, camera.live.delay_frames)
        return CameraMemory(gains=gains, before=radiance if camera.shutter.moves else None, video=memory.video)
