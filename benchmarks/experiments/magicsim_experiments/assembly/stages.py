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


def timeline(
    *, before_mm: float = 0.5, insertions: tuple[tuple[float, float], tuple[float, float]] = ((2.0, 2.0), (4.0, 4.0)),
    success_mm: float = 8.0,
) -> tuple[Step, ...]:  # fmt: skip
    """The six stages of one trial.

    Args:
        before_mm: How far before the mouth the approach ends [mm].
        insertions: Of the first and of the second: depth [mm], and the force at which the carriage stops [N].
        success_mm: Depth of the pin once it is aligned [mm].
    """
    (first_mm, first_n), (second_mm, second_n) = insertions
    return (
        Step(stage=Stage.GRIP, depth_mm=None),
        Step(stage=Stage.APPROACH, depth_mm=-before_mm),
        Step(stage=Stage.FIRST, depth_mm=first_mm, push_n=first_n),
        Step(stage=Stage.SECOND, depth_mm=second_mm, push_n=second_n),
        Step(stage=Stage.SUCCESS, depth_mm=success_mm, is_aligned=True),
        Step(stage=Stage.OPEN, depth_mm=success_mm, is_aligned=True),
    )


EARLY = (Stage.FIRST, Stage.SECOND)
"""Stages in which misalignment is to be noticed."""
BEFORE = Stage.APPROACH
"""The stage that they are compared with."""
