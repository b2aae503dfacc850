"""One moment of a live sensor: everything that its frame depends on."""

from dataclasses import dataclass

from magicsim.camera.stream import CameraMemory, Instant
from magicsim.deform.deformation import Deformation
from magicsim.scenes.timeline import FrameState

Rgb = tuple[float, float, float]
FULL: Rgb = (1.0, 1.0, 1.0)
"""All strengths as the rig has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """Everything that one frame depends on, held until it is developed."""

    index: int
    """Place in the stream; each frame has noise of its own."""
    time_s: float
    """Time since the stream began [s]."""
    seed: int
    """Seed of the stream's noise."""
    state: FrameState
    deformation: Deformation
    slid_mm: float
    """How far the skin has slid over the object since the stream began."""
    led_strength: Rgb
    """Radiance of the LED strips' red, green and blue in units of the rig's."""
    frames_per_second: float
    """Frame rate [1/s]."""
    memory: CameraMemory | None = None
    """What the camera inherits from the frames before; None at the stream's begin, and where it inherits nothing."""

    @property
    def at(self) -> Instant:
        """Which frame of which stream."""
        return Instant(seed=self.seed, index=self.index, time_s=self.time_s, frames_per_second=self.frames_per_second)
