"""One trial from the gripped plug on: the base comes and goes through the stages, and frames are taken.

The base comes along its way, step by step, until it pushes as hard as it may, or the plug is lost.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.objects.plain import PlugObject
from magicsim.geometry.pose import Pose
from magicsim.robot.fingers import object_pose
from magicsim.robot.grip.load import Hold
from magicsim.robot.grip.truth import GripMoment
from magicsim.robot.gripper import Gripper
from magicsim_experiments.assembly.meeting import FORWARD, MetLoad
from magicsim_experiments.assembly.stages import Misalignment, Step, TrialStage
from magicsim_experiments.assembly.trial import OPEN_MM, Gripped, Moment, Vector

LONGEST_STEP_MM = 0.5
"""Longest way of the carriage between two equilibria while the pin may meet the base [mm]."""
FROM_MM = 8.0
"""From how far before the end of a step the base comes that was not there before it [mm]; assumed."""


def carriage_ways(start: float | None, end: float, samples: int) -> tuple[float, list[float]]:
    """Where the carriage may meet the base first, and its places from there, the last one being the end.

    Args:
        start: Where it was [mm]; None where it was not there.
        end: Where it goes [mm].
        samples: Places where it is not near the base.
    """
    if start is None or max(start, end) <= 0:
        first, count = end - FROM_MM, samples
    else:
        first = min(max(start, 0.0), end)
        count = max(1, int(np.ceil(abs(end - first) / LONGEST_STEP_MM - 1e-9)))
    return first, evenly_to(first, end, count)


def evenly_to(first: float, end: float, count: int) -> list[float]:
    """Places evenly on the way from a first one, which is left out, to the last."""
    return [first + (end - first) * (number + 1) / count for number in range(count)]


def spread(count: int, samples: int) -> list[int]:
    """How many of so many places have passed at each sample: whole numbers up to all of them."""
    return sorted({round(count * number / samples) for number in range(1, samples + 1)} - {0})


MOST_SLIDE_MM = 6.0
"""Way of the plug in the grip in one step beyond which it is lost [mm]; assumed."""
WITHIN = 0.05
"""How far below the largest push the carriage may stop, in units of it."""
FINEST_MM, LOST_MM = 0.002, 0.02
"""Intervals of ways at which the search for that place, and for where the plug is lost, ends in any case [mm]."""
LEAST_SHARE = 0.1
"""Least share of the interval by which a guess shortens it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached:
    """One equilibrium on the way of the base."""

    way_mm: float
    """How far the pin's end would be below the mouth if nothing gave way [mm]."""
    moment: GripMoment
    """The fingers."""
    load: MetLoad
    met: Vector
    """Force [N] and torque [N mm] of the base on the plug; where this is lost, in the last balance before."""
    slid_mm: float
    """How far the plug has slid in the grip since the base began to push [mm]."""

    @property
    def push_n(self) -> float:
        """Size of the base's force [N]."""
        return float(np.linalg.norm(self.met[:3]))

    @property
    def is_lost(self) -> bool:
        """Whether the plug has dropped."""
        return self.moment.state.hold is Hold.DROPPED


class Pusher:
    """Holds the plug while the base comes."""

    def __init__(self, gripper: Gripper, plug: PlugObject, load_at: Callable[[float], MetLoad]) -> None:
        """Takes what does not change on the way; `load_at` is what acts with the base so far along it [mm]."""
        self._gripper, self._plug, self._load_at = gripper, plug, load_at

    def walk(self, first_mm: float, ways_mm: Sequence[float], push_n: float = np.inf) -> list[Reached]:
        """Equilibria at the ways [mm], the last of them where the base pushes with `push_n`, or the plug is lost.

        The base is at `first_mm` before it pushes harder than it does now.
        """
        load = self._load_at(first_mm)
        met = tuple(float(each) for each in load.met(object_pose(self._plug, self._gripper.place)))
        before = Reached(way_mm=first_mm, moment=self._gripper.now(), load=load, met=met, slid_mm=0.0)
        walked: list[Reached] = []
        for way in ways_mm:
            reached = self._reach(before, way)
            if reached.is_lost or reached.push_n > push_n:
                stopped = self._stop(before, reached, push_n)
                walked += [stopped] if not walked or stopped is not walked[-1] else []
                break
            walked.append(reached)
            before = reached
        return walked

    def walk_in_samples(
        self, first_mm: float, ways_mm: Sequence[float], push_n: float, *, samples: int
    ) -> list[Reached]:
        """Walks like `walk`; where that makes fewer equilibria than samples, the way is gone again in as many."""
        start = self._gripper.now()
        walked = self.walk(first_mm, ways_mm, push_n)
        if len(walked) >= samples:
            return walked
        end = walked[-1]
        self._gripper.go_back(start)
        finer = self.walk(first_mm, evenly_to(first_mm, end.way_mm, samples)[:-1])
        return finer if finer and finer[-1].is_lost else [*finer, end]

    def _reach(self, before: Reached, way_mm: float) -> Reached:
        """Moves the base on from an equilibrium."""
        self._gripper.go_back(before.moment)
        load = self._load_at(way_mm)
        lost = self._gripper.hold(load=load, most_slide_mm=MOST_SLIDE_MM) is Hold.DROPPED
        met: Array = np.array(before.met) if lost else load.met(object_pose(self._plug, self._gripper.place))
        return Reached(
            way_mm=way_mm, moment=self._gripper.now(), load=load, met=tuple(float(each) for each in met),
            slid_mm=before.slid_mm + self._gripper.truth().slid_mm,
        )  # fmt: skip

    def _stop(self, below: Reached, above: Reached, push_n: float) -> Reached:
        """Where the carriage stops between an equilibrium below its largest push and one that is too much."""
        least_n = (1 - WITHIN) * push_n
        while below.push_n < least_n and above.way_mm - below.way_mm > (LOST_MM if above.is_lost else FINEST_MM):
            tried = self._reach(below, below.way_mm + self._share(below, above, push_n) * (above.way_mm - below.way_mm))
            if tried.is_lost or tried.push_n > push_n:
                above = tried
            else:
                below = tried
        is_lost = above.is_lost and below.push_n < least_n
        stopped = replace(above, met=below.met) if is_lost else below
        self._gripper.go_back(stopped.moment)
        return stopped

    def _share(self, below: Reached, above: Reached, push_n: float) -> float:
        """Which share of the interval is tried next: to the middle of what is good enough, by a straight line."""
        if above.is_lost:
            return 0.5
        aim = (1 - WITHIN / 2) * push_n
        share = (aim - below.push_n) / (above.push_n - below.push_n)
        return min(max(share, LEAST_SHARE), 1 - LEAST_SHARE)


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
        self._pass((OPEN_MM + self._setup.config.squeeze_mm) / 2)
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
        slid_mm = 0.0
        for number in spread(len(walked), self._setup.samples):
            reached = walked[number - 1]
            self._gripper.go_back(reached.moment)
            self._load = reached.load
            self._film(step, after_mm=reached.way_mm - first, met=reached.met, slid_mm=reached.slid_mm - slid_mm)
            slid_mm = reached.slid_mm
        self._depth = walked[-1].way_mm
        self._load = replace(self._load, way=0.0)
        self._pass(self._depth - first)

    def _load_at(self, way_mm: float) -> MetLoad:
        """The plug's weight, and the base so far along its way."""
        off = None if self._is_aligned else self._misalignment
        return replace(self._gripped.load, base=_base(self._axis, self._tip_mm, way_mm, off), way=FORWARD)

    def _pass(self, way_mm: float) -> None:
        """Lets the time pass in which carriage or fingers go a way [mm]."""
        self._time_s += way_mm / self._setup.config.speed_mm_s

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
            step=step, outcome=truth.hold, time_s=self._time_s + after_mm / self._setup.config.speed_mm_s,
            base_force_n=met[:3], base_torque_nmm=met[3:],
            normal_n=(truth.upper.force_n[2] + truth.lower.force_n[2]) / 2, place=truth.place, limit=truth.limit,
            slid_mm=slid_mm, images=(pair.upper.image, pair.lower.image),
        )  # fmt: skip
        self.moments.append(moment)


def _base(axis: Pose, tip_mm: float, depth_mm: float, misalignment: Misalignment | None) -> Pose:
    """The jack in the gripper's frame: its mouth so far from the pin's end as it was gripped, along the fingers."""
    tip = axis.to_sensor(np.array([[0.0, tip_mm, 0.0]]))[0]
    if misalignment is None:
        return Pose(position_mm=tip - depth_mm * axis.rotation[:, 1], rotation=axis.rotation)
    mouth = tip + np.array([misalignment.x_mm, -depth_mm, misalignment.z_mm])
    return Pose.from_degrees(mouth, roll=misalignment.tilt_x_deg, yaw=misalignment.tilt_z_deg)
