"""The state of a scene at every frame, interpolated from its keyframes."""

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from magicsim.arrays import Array
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.geometry.pose import Pose
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import Keyframe, SceneConfig

LightOrigin = Literal["", "untouched", "outside", "before contact", "traced", "alone"]
"""`untouched`: that of the untouched sensor. `outside`: that, and what object and lamps outside change of it.
`before contact`: kept of the last state before contact (`render.light_change`). `traced`: particles of the frame in the
deformed block, anchored. `alone`: without the untouched sensor (`render.anchor_samples = 0`, or `volpath`)."""
ImageOrigin = Literal["", "untouched", "recorded", "traced", "alone", "compressed", "emulated"]
"""`untouched`: the image of the anchor, the untouched sensor. `recorded`: all of its camera paths, in other light.
`traced`: paths of some pixels traced anew, where something moved. `alone`: as for light. Of the fast tier
(`render.tier`) are `compressed`, before contact, and `emulated`, in it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """State of everything that light meets. Arrays are compared by identity: pass the same one while nothing moves."""

    body: Array | None = None
    """Deformed body vertices, shape (vertices, 3) [mm]; None at rest."""
    infill: Array | None = None
    """Deformed infill vertices, shape (vertices, 3) [mm]; None at rest."""
    markers: Array | None = None
    """Displaced vertices of markers below the face, shape (vertices, 3) [mm]; None at rest."""
    indenter: Indenter | None = None
    """The object where it is, or None."""
    flashlight_x_mm: float | None = None
    """Shift of the outside light [mm], or None while it is off."""
    facing_mm: float | None = None
    """Distance to the contact face of another finger that looks back [mm]; None without one."""
    is_released: bool = False
    """Whether a deformed block is touched no more, and only a dent is left."""
    passing_mm: float | None = None
    """Where something that passes in the room is along x [mm]; None while it is out of sight."""
    companion: Pose | None = None
    """Pose of what is seen beside the object and touches nothing; None while it is away."""

    @property
    def is_untouched(self) -> bool:
        """Whether this is the sensor alone, as the anchor holds it."""
        return self.is_undeformed and self.indenter is None and self.flashlight_x_mm is None and self.facing_mm is None

    @property
    def is_undeformed(self) -> bool:
        """Whether the block is as it was built, whatever stands before it."""
        return self.body is None and self.infill is None


class TierError(NamedTuple):
    """How far an emulated frame is off a true one, which has noise of its own [linear grey levels]."""

    mean: float
    """Mean distance of all pixels and channels."""
    p95: float
    """Distance that 95 % of them are below."""
    p99: float
    """Distance that 99 % of them are below."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """How one frame was made; empty where nobody said."""

    light: LightOrigin = ""
    image: ImageOrigin = ""
    error: TierError | None = None
    """How far an emulated frame is off, where it was rendered truly as well."""


UNKNOWN_ORIGIN = Origin()
ALONE = Origin(light="alone", image="alone")
AT_REST = Origin(light="untouched", image="untouched")


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameState:
    """What is where in one frame. Equal states look the same."""

    gap_mm: float | None
    """Gap of the object [mm], negative when pressed; None without an object."""
    x_mm: float
    y_mm: float
    twist_deg: float
    flashlight: bool
    light_x_mm: float
    tilt_x_deg: float = 0.0
    """Rotation vector of the object's tilt, applied after its twist: along x [degrees]."""
    tilt_y_deg: float = 0.0
    facing_mm: float | None = None
    """Distance to the contact face of another finger that looks back at this one [mm]; None without one."""
    passing_mm: float | None = None
    """Where something that passes in the room is along x [mm]; None while it is out of sight."""
    companion: tuple[float, ...] | None = None
    """Pose of what is seen beside the object and touches nothing, as `Pose.key` has it; None while it is away."""

    @property
    def has_object(self) -> bool:
        """Whether an object is there."""
        return self.gap_mm is not None

    @property
    def can_touch(self) -> bool:
        """Whether the object's highest point is above the undeformed contact face."""
        return self.gap_mm is not None and self.gap_mm < 0


UNTOUCHED = FrameState(gap_mm=None, x_mm=0.0, y_mm=0.0, twist_deg=0.0, flashlight=False, light_x_mm=0.0)
"""The sensor alone, as in the reference frames."""


def placed_in(state: FrameState, target: ObjectBase | None, design: ElastomerDesign) -> Indenter | None:
    """The object where a state has it before a block; None where there is none."""
    if state.gap_mm is None or target is None:
        return None
    return place_object(
        target, gap_mm=state.gap_mm, x_mm=state.x_mm, y_mm=state.y_mm, twist_deg=state.twist_deg,
        tilt_x_deg=state.tilt_x_deg, tilt_y_deg=state.tilt_y_deg, design=design,
    )  # fmt: skip


def timeline(scene: SceneConfig) -> list[FrameState]:
    """States of the scored frames, in order."""
    states = []
    for start, end in zip(scene.keyframes, (*scene.keyframes[1:], None), strict=True):
        last = end.frame if end is not None else start.frame + 1
        states += [
            _between(start, end, (frame - start.frame) / (last - start.frame)) for frame in range(start.frame, last)
        ]
    return _with_passing(scene, states, scene.references)


def reference_states(scene: SceneConfig) -> list[FrameState]:
    """States of the reference frames, in order."""
    return _with_passing(scene, [UNTOUCHED] * scene.references, 0)


def _with_passing(scene: SceneConfig, states: list[FrameState], first: int) -> list[FrameState]:
    """The states with what passes in the room where it is, the first being that of so manieth frame of the stream."""
    if scene.rig.moving is None:
        return states
    return [
        with_passing(state, scene.rig, time_s=number / scene.frames_per_second, seed=scene.seed)
        for number, state in enumerate(states, first)
    ]


def with_passing(state: FrameState, rig: Rig, *, time_s: float, seed: int) -> FrameState:
    """The state with what passes in the room at a time of the stream; with a facing finger the room is still."""
    passing = rig.moving if state.facing_mm is None else None
    return replace(state, passing_mm=passing.place_mm(time_s, seed) if passing is not None else None)


def _between(start: Keyframe, end: Keyframe | None, share: float) -> FrameState:
    target = start if end is None or end.gap_mm is None or start.gap_mm is None else end

    def mix(name: str, towards: Keyframe = target) -> float:
        a, b = getattr(start, name), getattr(towards, name)
        return round(float(a + share * (b - a)), 9)

    present = start.gap_mm is not None
    lit_target = end if end is not None and end.flashlight and start.flashlight else start
    return FrameState(
        gap_mm=mix("gap_mm") if present else None,
        x_mm=mix("x_mm") if present else 0.0,
        y_mm=mix("y_mm") if present else 0.0,
        twist_deg=mix("twist_deg") if present else 0.0,
        flashlight=start.flashlight,
        light_x_mm=mix("light_x_mm", lit_target) if start.flashlight else 0.0,
    )
