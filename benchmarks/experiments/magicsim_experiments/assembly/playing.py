"""One trial from the gripped plug on: the base comes and goes through the stages, and frames are taken."""

from collections.abc import Callable

import numpy as np

from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import object_pose
from magicsim.robot.grip.load import Hold
from magicsim.robot.gripper import Gripper
from magicsim_experiments.assembly.meeting import FORWARD, MetLoad, jack_pose
from magicsim_experiments.assembly.pushing import MOST_SLIDE_MM, Pusher, Vector, carriage_ways, evenly_to, spread
from magicsim_experiments.assembly.stages import Misalignment, Step, TrialStage
from magicsim_experiments.assembly.trial import OPEN_MM, Gripped, Moment


def play(
    gripper: Gripper, gripped: Gripped, misalignment: Misalignment, *, seed: int | None = None,
    tell: Callable[[TrialStage], None] | None = None,
) -> tuple[Moment, ...]:  # fmt: skip
    """Plays a trial from the gripped plug on; it ends early where the plug drops.

    Args:
        gripped: From `take_plug`.
        seed: Of the frames' noise, whose stream begins anew; the scene's by default.

    Returns:
        What was at the end of each step, or at each of its samples.
    """
    gripper.reset(seed=seed)
    gripper.go_back(gripped.moment)
    course = _Course(gripper, gripped, misalignment)
    for step in gripped.setup.timeline:
        if tell is not None:
            tell(step.stage)
        course.play(step)
        if gripper.outcome is Hold.DROPPED:
            break
    return tuple(course.moments)


class _Course:
    """Where the base is in one trial, and what was filmed."""

    def __init__(self, gripper: Gripper, gripped: Gripped, misalignment: Misalignment) -> None:
        self.moments: list[Moment] = []
        self._gripper, self._gripped, self._misalignment = gripper, gripped, misalignment
        self._setup, self._plug = gripped.setup, gripped.plug
        self._tip_mm = self._plug.length_mm / 2 + self._plug.pin_length_mm
        self._time_s = 0.0
        self._load, self._is_aligned = gripped.load, False
        self._axis = object_pose(self._plug, gripped.moment.state.place)
        self._depth: float | None = None

    def play(self, step: Step) -> None:
        """Films one step."""
        if step.depth_mm is None:
            self._close(step)
        elif step.stage is TrialStage.OPEN:
            self._open(step)
        else:
            self._push(step, step.depth_mm)

    def _close(self, step: Step) -> None:
        """The fingers come to the plug and grip it."""
        ways = evenly_to(0.0, OPEN_MM, self._setup.samples)
        for closing, way_mm in zip(self._gripped.closing, ways, strict=False):
            self._gripper.go_back(closing)
            self._film(step, after_mm=way_mm / 2)
        self._gripper.go_back(self._gripped.moment)
        self._pass((OPEN_MM + self._setup.squeeze_mm) / 2)
        self._film(step)

    def _open(self, step: Step) -> None:
        """The fingers open, the base keeps the plug."""
        for way_mm in evenly_to(0.0, OPEN_MM, self._setup.samples):
            self._gripper.close(self._gripper.touching_width_mm + way_mm, place=self._gripper.place)
            self._film(step, after_mm=way_mm / 2)
        self._pass(OPEN_MM / 2)

    def _push(self, step: Step, depth_mm: float) -> None:
        """The base comes along its axis, after it was lifted off and brought above the jack by sight where it is to."""
        stood = self._depth
        if step.is_aligned and not self._is_aligned:
            self._gripper.hold(load=self._gripped.load, most_slide_mm=MOST_SLIDE_MM)
            self._axis, self._depth = object_pose(self._plug, self._gripper.place), None
        self._is_aligned = step.is_aligned
        first, ways = carriage_ways(self._depth, depth_mm, self._setup.samples)
        self._pass(0.0 if stood is None else abs(stood - first))
        pusher = Pusher(self._gripper, self._plug, self._load_at)
        walked = pusher.walk_in_samples(first, ways, step.push_n, samples=self._setup.samples)
        done = 0
        for number in spread(len(walked), self._setup.samples):
            reached = walked[number - 1]
            self._gripper.go_back(reached.moment)
            self._load = reached.load
            slid = sum(each.slid_mm for each in walked[done:number])
            self._film(step, after_mm=reached.way_mm - first, met=reached.met, slid_mm=slid)
            done = number
        self._depth = walked[-1].way_mm
        self._load = self._load.at(self._load.base, way=0.0)
        self._pass(self._depth - first)

    def _load_at(self, way_mm: float) -> MetLoad:
        """The plug's weight, and the base so far along its way."""
        off = None if self._is_aligned else self._misalignment
        return self._gripped.load.at(_base(self._axis, self._tip_mm, way_mm, off), way=FORWARD)

    def _pass(self, way_mm: float) -> None:
        """Lets the time pass in which carriage or fingers go a way [mm]."""
        self._time_s += way_mm / self._setup.speed_mm_s

    def _film(self, step: Step, *, after_mm: float = 0.0, met: Vector | None = None, slid_mm: float = 0.0) -> None:
        """A pair of frames; what the base does is `met`, or what it does to the plug where that is."""
        gripper = self._gripper
        if gripper.has_companion:
            gripper.accompany(self._load.base)
        pair = gripper.frames()
        truth = pair.truth
        if met is None:
            met = tuple(float(each) for each in self._load.met(object_pose(self._plug, truth.place)))
        moment = Moment(
            step=step, outcome=truth.hold, time_s=self._time_s + after_mm / self._setup.speed_mm_s,
            base_force_n=met[:3], base_torque_nmm=met[3:],
            normal_n=(truth.upper.force_n[2] + truth.lower.force_n[2]) / 2, place=truth.place, limit=truth.limit,
            slid_mm=slid_mm, images=(pair.upper.image, pair.lower.image),
        )  # fmt: skip
        self.moments.append(moment)


def _base(axis: Pose, tip_mm: float, depth_mm: float, misalignment: Misalignment | None) -> Pose:
    """The jack in the gripper's frame: its mouth so far from the pin's end as it was gripped, along the fingers."""
    off = misalignment or Misalignment(kind="aligned")
    tip = axis.to_sensor(np.array([[0.0, tip_mm, 0.0]]))[0]
    if misalignment is None:
        return Pose(position_mm=tip - depth_mm * axis.rotation[:, 1], rotation=axis.rotation)
    mouth = (float(tip[0]) + off.x_mm, float(tip[1]) - depth_mm, float(tip[2]) + off.z_mm)
    return jack_pose(mouth_mm=mouth, tilt_x_deg=off.tilt_x_deg, tilt_z_deg=off.tilt_z_deg)
