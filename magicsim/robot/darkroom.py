"""Moments of a live sensor and the frames that they are developed into.

Equal states are rendered once, exposure is metered once.
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.camera.camera import Camera
from magicsim.camera.stream import CameraMemory, Instant
from magicsim.config.models import validate
from magicsim.deform.deformation import Deformation
from magicsim.errors import ConfigError
from magicsim.geometry.limits import PressLimits
from magicsim.scenes.rig import DARK, Rig
from magicsim.scenes.scene import OutputSettings
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin
from magicsim.simulation.episode import FrameTruth, SimulatedFrame
from magicsim.simulation.sensor import Sensor, sensor_camera
from magicsim.simulation.stream import RenderedState, Shot
from magicsim.simulation.truth import frame_truth

Rgb = tuple[float, float, float]
FULL: Rgb = (1.0, 1.0, 1.0)
"""All strengths as the rig has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment(Instant):
    """Everything that one frame depends on, held until it is developed."""

    state: FrameState = UNTOUCHED
    deformation: Deformation
    slid_mm: float = 0.0
    """How far the skin has slid over the object since the stream began."""
    led_strength: Rgb = FULL
    """Radiance of the LED strips' red, green and blue in units of the rig's."""
    memory: CameraMemory | None = None
    """What the camera inherits from the frames before; None at the stream's begin, and where it inherits nothing."""

    def truth(self, limits: PressLimits) -> FrameTruth:
        """Ground truth in the sensor's frame, without rendering."""
        return frame_truth(
            self.state, self.deformation, limits, index=self.index, time_s=self.time_s, is_reference=False
        )


REMEMBERED = 3
"""Radiance images that are kept of each kind: the untouched sensor's, and a state with and without outside light."""


class Darkroom:
    """Renders what a sensor sees, in any order of moments."""

    def __init__(self, sensor: Sensor, output: OutputSettings) -> None:
        """For one sensor, whose renderer loads with the first frame."""
        self.sensor = sensor
        self._output = output
        self._shot: Shot | None = None
        self._seen: dict[tuple[FrameState, int], tuple[Deformation, FloatImage, Origin]] = {}
        self._strips: Darkroom | None = None

    def develop(self, moment: Moment) -> SimulatedFrame:
        """Renders a moment; `RenderError` where the image is not valid."""
        ready, origin = self._ready, self._made(moment.state, moment.deformation)[1]
        seen = RenderedState(
            state=moment.state, deformation=moment.deformation, radiance=self._lit(moment), origin=origin,
            is_reference=False,
        )  # fmt: skip
        frame, _ = ready.take(seen, self._memory(moment), moment)
        self.sensor.limits.see(frame.truth.beyond_limits)
        return frame

    def passed(self, moment: Moment) -> CameraMemory:
        """What the camera's next frame inherits when this moment has gone by, developed or not."""
        return self._ready.camera.passed(self._lit(moment), self._memory(moment), moment)

    def exposed(self, exposure_grey: float) -> "Darkroom":
        """One that meters again on the untouched sensor, aiming at another mean grey level; nothing is rendered."""
        other = copy(self)
        other.sensor = self.sensor.with_rig(self._rig_with("exposure", exposure_grey=exposure_grey), is_alike=True)
        other._shot = None
        return other

    def resized(self, *, columns: int, rows: int) -> "Darkroom":
        """One that renders with so many pixels, and meters again; what they see along x stays `camera.field_mm`."""
        rig = self._rig_with("image size", columns=columns, rows=rows)
        return self if rig == self.sensor.rig else Darkroom(self.sensor.with_rig(rig), self._output)

    def _rig_with(self, source: str, **values: float) -> Rig:
        rig = self.sensor.rig
        camera = validate(Camera, rig.camera.model_dump() | values, source=source)
        return rig.model_copy(update={"camera": camera})

    @property
    def is_metered(self) -> bool:
        """Whether the untouched sensor was rendered and the camera exposed on it."""
        return self._shot is not None

    @property
    def _ready(self) -> Shot:
        if self._shot is None:
            untouched = self._radiance(UNTOUCHED, self.sensor.rest)
            self._shot = Shot.of(self.sensor, self._output, sensor_camera(self.sensor, untouched))
        return self._shot

    def _memory(self, moment: Moment) -> CameraMemory:
        return moment.memory or self._ready.camera.begin(moment.frames_per_second)

    def _lit(self, moment: Moment) -> FloatImage:
        """Radiance at the strengths of the LEDs: colours do not mix on their way, so each strength scales its channel.

        Light from outside is not scaled: it is what flashlight and room add to the same state without them.
        """
        full = self._radiance(moment.state, moment.deformation)
        if moment.led_strength == FULL:
            return full
        if moment.state.facing_mm is not None:
            raise ConfigError(
                f"LED strength = {moment.led_strength} is not allowed before another finger, whose light it would scale"
            )
        strength = np.array(moment.led_strength, np.float32)
        if not moment.state.flashlight and self._by_strips is self:
            return full * strength
        dark = replace(moment.state, flashlight=False, light_x_mm=0.0, passing_mm=None)
        inside = self._by_strips._radiance(dark, moment.deformation)
        return np.asarray(np.maximum(inside * strength + (full - inside), 0))

    @property
    def _by_strips(self) -> "Darkroom":
        """The sensor in a dark room: itself, where its own is."""
        rig = self.sensor.rig
        if max(rig.room_light) == 0:
            return self
        if self._strips is None:
            self._strips = Darkroom(self.sensor.with_rig(rig.model_copy(update={"room": DARK})), self._output)
        return self._strips

    def _radiance(self, state: FrameState, deformation: Deformation) -> FloatImage:
        return self._made(state, deformation)[0]

    def _made(self, state: FrameState, deformation: Deformation) -> tuple[FloatImage, Origin]:
        key = (state, id(deformation))  # the deformation is kept beside, so that no other one gets its id
        if key not in self._seen:
            while len(self._seen) >= REMEMBERED:
                del self._seen[next(iter(self._seen))]
            self._seen[key] = (deformation, *self.sensor.render(state, deformation))
        return self._seen[key][1:]
