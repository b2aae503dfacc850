"""The six stages of an assembly as a scripted timeline (Fan, Li, Zhang, arXiv 2505.24382: a teleoperator plugs in).

How far and how hard each stage goes is assumed; the stages' names and order are published.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

import numpy as np

Kind = Literal["aligned", "offset", "angle"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Ranges of misalignments; published are 'above 3 mm' and 'slight angles', the rest is assumed."""

    offset_mm: tuple[float, float] = (3.0, 6.0)
    """Smallest and largest offset of a base beside the axis [mm]."""
    angle_deg: tuple[float, float] = (3.0, 8.0)
    """Smallest and largest angle of a base [degrees]."""
    aligned_mm: float = 0.3
    """Largest offset of a base that counts as aligned [mm]: the chamfer takes it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Misalignment:
    """Misalignment of the base against the plug, in the gripper's frame."""

    kind: Kind
    x_mm: float = 0.0
    """Offset across the fingers [mm]."""
    z_mm: float = 0.0
    """Offset along the closing axis [mm]."""
    tilt_x_deg: float = 0.0
    tilt_z_deg: float = 0.0
    """Angle about the closing axis [degrees]."""

    @property
    def is_misaligned(self) -> bool:
        """Whether the trial is one that should be noticed."""
        return self.kind != "aligned"


def draw_misalignments(trials: int, seed: int, spread: Spread | None = None) -> list[Misalignment]:
    """Misalignments of a number of trials: in turn aligned, beside and at an angle, in directions drawn evenly."""
    ranges = spread or Spread()
    rng = np.random.default_rng([seed, 38])
    kinds: tuple[Kind, ...] = ("offset", "angle", "aligned")
    drawn = []
    for number in range(trials):
        kind, direction = kinds[number % len(kinds)], float(rng.uniform(0, 2 * math.pi))
        x, z = math.cos(direction), math.sin(direction)
        size = float(rng.uniform(0, 1))
        if kind == "angle":
            angle = _between(ranges.angle_deg, size)
            drawn.append(Misalignment(kind=kind, tilt_x_deg=angle * x, tilt_z_deg=angle * z))
        else:
            offset = size * ranges.aligned_mm if kind == "aligned" else _between(ranges.offset_mm, size)
            drawn.append(Misalignment(kind=kind, x_mm=offset * x, z_mm=offset * z))
    return drawn


def _between(ends: tuple[float, float], share: float) -> float:
    return ends[0] + share * (ends[1] - ends[0])


class TrialStage(StrEnum):
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

    stage: TrialStage
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
        Step(stage=TrialStage.GRIP, depth_mm=None),
        Step(stage=TrialStage.APPROACH, depth_mm=-before_mm),
        Step(stage=TrialStage.FIRST, depth_mm=first_mm, push_n=first_n),
        Step(stage=TrialStage.SECOND, depth_mm=second_mm, push_n=second_n),
        Step(stage=TrialStage.SUCCESS, depth_mm=success_mm, is_aligned=True),
        Step(stage=TrialStage.OPEN, depth_mm=success_mm, is_aligned=True),
    )


EARLY = (TrialStage.FIRST, TrialStage.SECOND)
"""Stages in which misalignment is to be noticed."""
BEFORE = TrialStage.APPROACH
"""The stage that they are compared with."""
