"""The base comes along its way, step by step, until it pushes as hard as it may, or the plug is lost."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.objects.plain import PlugObject
from magicsim.robot.fingers import object_pose
from magicsim.robot.grip.load import Hold
from magicsim.robot.grip.truth import GripMoment
from magicsim.robot.gripper import Gripper
from magicsim_experiments.assembly.meeting import MetLoad

LONGEST_STEP_MM = 0.5
"""Longest way of the carriage between two equilibria while the pin may meet the base [mm]."""
FROM_MM = 8.0
"""From how far before the end of a step the base comes that was not there before it [mm]; assumed."""


def carriage_ways(start: float | None, end: float, samples: int) -> tuple[float, list[float]]:
    """Where the carriage may meet the base first, and its places from there, the last one being the end.

    Args:
        start: Where it was; None where it was not there.
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

Vector = tuple[float, ...]


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
    """How far the plug slid in the grip since the equilibrium before [mm]."""

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
        """Takes what does not change on the way.

        Args:
            load_at: What acts with the base so far along its way [mm].
        """
        self._gripper, self._plug, self._load_at = gripper, plug, load_at

    def walk(self, first_mm: float, ways_mm: Sequence[float], push_n: float = np.inf) -> list[Reached]:
        """Equilibria at the ways, the last of them where the base pushes with its most, or the plug is lost.

        Args:
            first_mm: Where the base is before it pushes harder than it does now [mm].
            ways_mm: Where it goes, in their order [mm].
            push_n: Force at which the carriage stops [N].
        """
        load = self._load_at(first_mm)
        met = tuple(float(each) for each in load.met(object_pose(self._plug, self._gripper.place)))
        before = Reached(way_mm=first_mm, moment=self._gripper.now(), load=load, met=met, slid_mm=0.0)
        walked: list[Reached] = []
        for way in ways_mm:
            reached = self._reach(before, way)
            if reached.is_lost or reached.push_n > push_n:
                walked.append(self._stop(before, reached, push_n))
                break
            walked.append(reached)
            before = reached
        return walked

    def walk_in_samples(
        self, first_mm: float, ways_mm: Sequence[float], push_n: float, *, samples: int
    ) -> list[Reached]:
        """Walks like `walk`; where that makes fewer equilibria than samples, the way is gone again in as many.

        Args:
            first_mm: Where the base is before it pushes harder than it does now [mm].
            ways_mm: Where it goes, in their order [mm].
            push_n: Force at which the carriage stops [N].
        """
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
            slid_mm=self._gripper.truth().slid_mm,
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
