"""The six stages of an assembly as a scripted timeline (Fan, Li, Zhang, arXiv 2505.24382: a teleoperator plugs in).

How far and how hard each stage goes is assumed; the stages' names and order are published.
"""

import math
from dataclasses import dataclass
from enum import StrEnum


class Stage(StrEnum):
    """What the gripper does."""

    GRIP = "a grip"
    """The fingers close on the plug and lift it."""
    APPROACH = "b approach"
    """The base comes near, aligned as well as the trial is."""
    FIRST = "c first insertion"
    """The plug meets the base."""
    SECOND = "d second insertion"
    """Harder."""
    SUCCESS = "e success"
    """Aligned, the pin goes in."""
    OPEN = "f open"
    """The fingers open; the base keeps the plug."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One way of the carriage, at whose end a pair of frames is taken."""

    stage: Stage
    depth_mm: float | None
    """How far the pin's end would be below the mouth if nothing gave way, negative before it [mm]; None is no base."""
    push_n: float = math.inf
    """Force of the base at which the carriage stops earlier [N]."""
    is_aligned: bool = False
    """Whether the base is on the plug's axis, whatever the trial's misalignment."""


TIMELINE = (
    Step(stage=Stage.GRIP, depth_mm=None),
    Step(stage=Stage.APPROACH, depth_mm=-0.5),
    Step(stage=Stage.FIRST, depth_mm=2.0, push_n=2.0),
    Step(stage=Stage.SECOND, depth_mm=4.0, push_n=4.0),
    Step(stage=Stage.SUCCESS, depth_mm=8.0, is_aligned=True),
    Step(stage=Stage.OPEN, depth_mm=8.0, is_aligned=True),
)
"""One trial."""
EARLY = (Stage.FIRST, Stage.SECOND)
"""Stages in which misalignment is to be noticed."""
BEFORE = Stage.APPROACH
"""The stage that they are compared with."""
