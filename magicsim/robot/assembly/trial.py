"""One trial: the gripper takes the plug, brings it to the base through the six stages, and frames are taken."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from magicsim.arrays import Frame
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.plug import PlugObject
from magicsim.geometry.pose import Pose
from magicsim.robot.assembly.base_body import base_body
from magicsim.robot.assembly.jack import Jack, jack_pose
from magicsim.robot.assembly.meeting import FORWARD, Contact, MetLoad
from magicsim.robot.assembly.misaligned import Misalignment
from magicsim.robot.assembly.stages import TIMELINE, Stage, Step
from magicsim.robot.assembly.surface import plug_elements
from magicsim.robot.assembly.ways import carriage_ways, evenly_to, spread
from magicsim.robot.fingers import ObjectPlace, object_pose
from magicsim.robot.grip.outcome import Hold
from magicsim.robot.grip.truth import GripMoment
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace

Vector = tuple[float, ...]
Walked = list[tuple[GripMoment, MetLoad, float]]
"""Equilibria of one step: the fingers, what acted, and how far the plug slid on the way there [mm]."""
SQUEEZE_MM, OPEN_MM = 1.0, 12.0
"""How much closer than touching the faces grip, and how far they open [mm]; assumed."""
MASS_G = 8.0
"""Mass of the plug; assumed."""
PLACE = ObjectPlace(y_mm=6.0)
"""Where the fingers take the handle: towards their tips, the pin beyond them."""
MOST_SLIDE_MM = 6.0
"""Way of the plug in the grip in one step beyond which it is lost [mm]; assumed."""
SPACE = Workspace(
    x_mm=(-1.5, 1.5), y_mm=(0.0, 8.0), twist_deg=(-15.0, 15.0), tilt_x_deg=(-15.0, 15.0), tilt_y_deg=(-15.0, 15.0),
    gap_mm=(-1.5, 20.0),
)  # fmt: skip
"""Where the plug may go in the grip."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What does not change from trial to trial."""

    jack: Jack = field(default_factory=Jack)
    contact: Contact = field(default_factory=Contact)
    squeeze_mm: float = SQUEEZE_MM
    """How much closer than touching the faces grip [mm]."""
    place: ObjectPlace = PLACE
    """Where the fingers take the handle."""
    timeline: Sequence[Step] = TIMELINE
    references: int = 30
    """Frames of the untouched fingers, for the detectors."""
    samples: int = 1
    """Pairs of frames of each step, the last one at its end, the others evenly along its way; where the base stops it
    after fewer equilibria, it is gone again in as many."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """One step of a trial, labels and pictures."""

    step: Step
    outcome: Hold
    base_force_n: Vector
    """Force of the base on the plug, in the gripper's frame [N]."""
    base_torque_nmm: Vector
    """About the plug's origin [N mm]."""
    normal_n: float
    """Mean normal force of both fingers [N]."""
    place: ObjectPlace
    """The plug in the gripper's frame."""
    slid_mm: float
    """How far it slid in the grip on the way to this step [mm]."""
    images: tuple[Frame, Frame]
    """Upper and lower finger's frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gripped:
    """The plug in the grip, from which each trial begins."""

    plug: PlugObject
    setup: Setup
    moment: GripMoment
    load: MetLoad
    """Its weight, no base yet."""
    references: tuple[list[Frame], list[Frame]]
    """Frames of the upper and of the lower finger with nothing between them."""
    closing: tuple[GripMoment, ...] = ()
    """The fingers on their way to the plug, of which further pairs of frames of the first step are taken."""


def base_of(plug: PlugObject, setup: Setup | None = None) -> SurfaceMesh:
    """The base's body, which a gripper shows that was built with it as its `companion`.

    Args:
        plug: Held by its handle.
        setup: Jack and grip.
    """
    setup = setup or Setup()
    return base_body(setup.jack, apart_mm=2 * plug.radius_mm - setup.squeeze_mm)


def take_plug(gripper: Gripper, plug: PlugObject, setup: Setup | None = None) -> Gripped:
    """Films the empty fingers, and grips the plug.

    Args:
        gripper: Two sensors with the plug as their object.
        plug: The plug.
        setup: Jack, contact and timeline.

    Raises:
        ConfigError: The plug does not fit, drops at once, or lies outside of a finger's workspace.
        ConvergenceError: No valid equilibrium was found.
    """
    setup = setup or Setup()
    gripper.reset()
    references = _references(gripper, setup.references)
    load = replace(
        MetLoad.of_mass(MASS_G, down=(0.0, 1.0, 0.0)), elements=plug_elements(plug), jack=setup.jack,
        contact=setup.contact,
    )  # fmt: skip
    touching, closing = gripper.touching_width_mm, []
    for left in range(setup.samples - 1, 0, -1):
        gripper.close(touching + OPEN_MM * left / setup.samples, place=setup.place)
        closing.append(gripper.now())
    gripper.close(touching - setup.squeeze_mm, place=setup.place)
    if gripper.hold(load=load) is Hold.DROPPED:
        msg = f"squeeze_mm = {setup.squeeze_mm:g} is not allowed: a plug of {load.weight_n:.3g} N drops at once"
        raise ConfigError(msg)
    return Gripped(
        plug=plug, setup=setup, moment=gripper.now(), load=load, references=references, closing=tuple(closing)
    )


def play(
    gripper: Gripper,
    gripped: Gripped,
    misalignment: Misalignment,
    *,
    seed: int | None = None,
    tell: Callable[[Stage], None] | None = None,
) -> tuple[Moment, ...]:
    """Plays a trial from the gripped plug on; it ends early where the plug drops.

    Args:
        gripper: That which has gripped it.
        gripped: From `take_plug`.
        misalignment: Of the base.
        seed: Of the frames' noise, whose stream begins anew; the scene's by default.
        tell: Told each step's stage as it begins.

    Returns:
        What was at the end of each step.

    Raises:
        ConfigError: The plug leaves a finger's workspace.
        ConvergenceError: A place has no valid equilibrium.
    """
    gripper.reset(seed=seed)
    plug, load, setup = gripped.plug, gripped.load, gripped.setup
    moments: list[Moment] = []
    for moment in gripped.closing:
        gripper.go_back(moment)
        moments.append(_moment(gripper, plug, setup.timeline[0], load, 0.0))
    gripper.go_back(gripped.moment)
    axis = object_pose(plug, gripper.place)
    depth: float | None = None
    tip = plug.length_mm / 2 + plug.pin_length_mm
    for step in setup.timeline:
        if tell is not None:
            tell(step.stage)
        walked: Walked = []
        if step.stage is Stage.OPEN:
            load = load.at(load.base, way=0.0)
            for number in range(1, setup.samples + 1):
                gripper.close(gripper.touching_width_mm + OPEN_MM * number / setup.samples, place=gripper.place)
                walked.append((gripper.now(), load, 0.0))
        elif step.depth_mm is not None:
            if step.is_aligned and not (moments and moments[-1].step.is_aligned):
                # Lifted off and brought above the jack by sight
                gripper.hold(load=load.at(None, way=0.0), most_slide_mm=MOST_SLIDE_MM)
                axis, depth = object_pose(plug, gripper.place), None
            off = None if step.is_aligned else misalignment
            first, ways = carriage_ways(depth, step.depth_mm, setup.samples)
            loads = [load.at(_base(axis, tip, each, off), way=FORWARD) for each in ways]
            start, walked = gripper.now(), _walk(gripper, plug, loads, step.push_n)
            depth = ways[len(walked) - 1]
            if len(walked) < setup.samples:
                gripper.go_back(start)
                finer = evenly_to(first, depth, setup.samples)
                walked = _walk(gripper, plug, [load.at(_base(axis, tip, each, off), way=FORWARD) for each in finer])
            load = walked[-1][1]
        else:
            walked.append((gripper.now(), load, 0.0))
        before = 0
        for now in spread(len(walked), setup.samples):
            moment, acting, _ = walked[now - 1]
            gripper.go_back(moment)
            moments.append(_moment(gripper, plug, step, acting, sum(slid for _, _, slid in walked[before:now])))
            before = now
        if gripper.outcome is Hold.DROPPED:
            break
    return tuple(moments)


def check_plug(plug: object) -> PlugObject:
    """The plug of a scene.

    Raises:
        ConfigError: Its object is none.
    """
    if not isinstance(plug, PlugObject):
        kind = getattr(plug, "kind", None)
        msg = f"object.kind = {kind!r} is not allowed here: an assembly needs a 'plug'"
        raise ConfigError(msg)
    return plug


def _references(gripper: Gripper, count: int) -> tuple[list[Frame], list[Frame]]:
    frames: tuple[list[Frame], list[Frame]] = ([], [])
    for finger, own in zip(gripper.fingers, frames, strict=True):
        finger.remove_object()
        own += [finger.frame().image for _ in range(count)]
    return frames


def _walk(gripper: Gripper, plug: PlugObject, loads: Sequence[MetLoad], push_n: float = np.inf) -> Walked:
    """Holds the plug while the base comes, until it pushes too hard or the plug drops."""
    walked: Walked = []
    for load in loads:
        gripper.hold(load=load, most_slide_mm=MOST_SLIDE_MM)
        walked.append((gripper.now(), load, gripper.truth().slid_mm))
        met = load.met(object_pose(plug, gripper.place))
        if gripper.outcome is Hold.DROPPED or np.linalg.norm(met[:3]) > push_n:
            break
    return walked


def _base(axis: Pose, tip_mm: float, depth_mm: float, misalignment: Misalignment | None) -> Pose:
    """The jack in the gripper's frame: its mouth so far from the pin's end as it was gripped, along the fingers."""
    off = misalignment or Misalignment(kind="aligned")
    tip = axis.to_sensor(np.array([[0.0, tip_mm, 0.0]]))[0]
    if misalignment is None:
        return Pose(position_mm=tip - depth_mm * axis.rotation[:, 1], rotation=axis.rotation)
    mouth = (float(tip[0]) + off.x_mm, float(tip[1]) - depth_mm, float(tip[2]) + off.z_mm)
    return jack_pose(mouth_mm=mouth, tilt_x_deg=off.tilt_x_deg, tilt_z_deg=off.tilt_z_deg)


def _moment(gripper: Gripper, plug: PlugObject, step: Step, load: MetLoad, slid_mm: float) -> Moment:
    if gripper.has_companion:
        gripper.accompany(load.base)
    pair = gripper.frames()
    truth = pair.truth
    force = [float(each) for each in load.met(object_pose(plug, gripper.place))]
    return Moment(
        step=step,
        outcome=truth.hold,
        base_force_n=tuple(force[:3]),
        base_torque_nmm=tuple(force[3:]),
        normal_n=(truth.upper.force_n[2] + truth.lower.force_n[2]) / 2,
        place=truth.place,
        slid_mm=slid_mm,
        images=(pair.upper.image, pair.lower.image),
    )
