"""A scene: a design on a rig, and what moves. The configuration of `scenes/*.toml`."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.config import Config
from magicsim.geometry.objects import ObjectConfig

GapMm = Annotated[float, Field(ge=-12, le=200)]
Seed = Annotated[int, Field(ge=0, lt=2**31)]


class Keyframe(Config):
    """State at one frame; between keyframes everything moves linearly, what is absent stays absent."""

    frame: Annotated[int, Field(ge=0)]
    """Index among the scored frames (the reference frames come before and are not counted)."""
    gap_mm: GapMm | None = None
    """Distance of the object's highest point from the undeformed contact face [mm], negative when pressed; left out
    means that there is no object."""
    x_mm: float = 0.0
    """Object's origin along x [mm]."""
    y_mm: float = 0.0
    """Object's origin along y [mm]."""
    twist_deg: float = 0.0
    """Object's rotation about z [degrees]."""
    flashlight: bool = False
    """Whether the outside light is on, from this frame to the next keyframe."""
    light_x_mm: float = 0.0
    """Shift of the flashlight along x [mm]."""


class ContactOptics(Config):
    """What light sees between skin and object in contact."""

    coupling: Literal["wet", "dry"] = "wet"
    """Wet: the tacky skin couples optically to the object. Dry: a thin film of air stays between them."""
    film_mm: Annotated[float, Field(ge=0.01, le=0.1)] = 0.02
    """Thickness of the film of air in dry contact [mm]."""


class RenderSettings(Config):
    """How radiance is computed."""

    estimator: Literal["fluence", "path"] = "fluence"
    """Cached fluence, or Mitsuba's volumetric path tracer."""
    samples: Annotated[int, Field(ge=1, le=65536)] = 8
    """Camera samples a pixel."""
    particles: Annotated[int, Field(ge=100, le=100_000_000)] = 100_000
    """Light particles shared by the LED strips; an outside light gets as many again."""
    anchor_samples: Annotated[int, Field(ge=0, le=65536)] = 64
    """Camera samples of the untouched state, to which an episode is anchored; 0 means no anchor."""
    anchor_particles: Annotated[int, Field(ge=0, le=100_000_000)] = 2_000_000
    """Light particles of the untouched state."""


class SceneConfig(Config):
    """One episode of one sensor."""

    schema_version: Literal[1]
    design: str
    """Design preset or file."""
    rig: str
    """Rig preset or file."""
    seed: Seed = 0
    """Seed of everything random in the episode."""
    references: Annotated[int, Field(ge=0, le=1000)] = 30
    """Frames of the untouched sensor before the scored ones."""
    frames_per_second: Annotated[float, Field(gt=0, le=1000)] = 15.0
    """Frame rate [1/s]."""
    object: ObjectConfig | None = None
    """What approaches."""
    contact: ContactOptics = ContactOptics()
    render: RenderSettings = RenderSettings()
    keyframes: Annotated[tuple[Keyframe, ...], Field(min_length=1)]
    """States in order of frame; the last one ends the episode."""

    @model_validator(mode="after")
    def _check_keyframes(self) -> Self:
        frames = [keyframe.frame for keyframe in self.keyframes]
        if frames[0] != 0 or any(later <= earlier for earlier, later in zip(frames, frames[1:], strict=False)):
            msg = f"keyframes.frame = {frames} is not allowed: must start at 0 and increase"
            raise ValueError(msg)
        if self.object is None and any(keyframe.gap_mm is not None for keyframe in self.keyframes):
            msg = "object is missing: a keyframe gives gap_mm, so [object] must say what approaches"
            raise ValueError(msg)
        return self

    @property
    def frame_count(self) -> int:
        """Number of scored frames."""
        return self.keyframes[-1].frame + 1
