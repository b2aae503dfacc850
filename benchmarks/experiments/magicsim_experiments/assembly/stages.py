"""Settings of an assembly, and its six stages as a scripted timeline (Fan, Li, Zhang, arXiv 2505.24382).

There a teleoperator plugs in. How far and how hard each stage goes is assumed; the stages' names and order are
published.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field

from magicsim.config.models import Config, apply_overrides, validate
from magicsim_experiments.assembly.meeting import Contact, Jack
from magicsim_experiments.task.settings import Positive, in_order

PREFIX = "task."
"""What settings of the task begin with; all others are the scene's."""
Offset = Annotated[float, Field(ge=0, le=20)]
Angle = Annotated[float, Field(ge=0, le=30)]
Kind = Literal["aligned", "offset", "angle"]


class AssemblyConfig(Config):
    """One run of the assembly task; every number is assumed where nothing else is said."""

    jack: Jack = Jack()
    """The hole in the base."""
    contact: Contact = Contact()
    """Contact between plug and base."""
    mass_g: Positive = 8.0
    """Mass of the plug [g]."""
    squeeze_mm: Annotated[float, Field(gt=0, le=4)] = 1.0
    """How much closer than touching the faces grip [mm]."""
    speed_mm_s: Positive = 10.0
    """Speed of the carriage and of each finger [mm/s]."""
    before_mm: Annotated[float, Field(gt=0, le=8)] = 0.5
    """How far before the mouth the approach ends [mm]."""
    insertion_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = (2.0, 4.0)
    """How far the pin would go in the first and in the second insertion if nothing gave way [mm]."""
    push_n: tuple[Positive, Positive] = (2.0, 4.0)
    """Force of the base at which the carriage stops in the first and in the second insertion [N]."""
    success_mm: Positive = 8.0
    """Depth of the pin once it is aligned [mm]."""
    offset_mm: Annotated[tuple[Offset, Offset], AfterValidator(in_order)] = (3.0, 6.0)
    """Smallest and largest offset of a base beside the axis [mm]; published is 'above 3 mm'."""
    angle_deg: Annotated[tuple[Angle, Angle], AfterValidator(in_order)] = (3.0, 8.0)
    """Smallest and largest angle of a base [degrees]; published are 'slight angles'."""
    aligned_mm: Offset = 0.3
    """Largest offset of a base that counts as aligned [mm]: the chamfer has to take it."""

    def _problems(self) -> Iterator[str]:
        most = self.jack.depth_mm
        if self.success_mm > most:
            yield f"success_mm = {self.success_mm:g} is not allowed: must be at most {most:g}, the depth of the jack"


def split_settings(settings: Sequence[str]) -> tuple[list[str], AssemblyConfig]:
    """Settings of the scene, and the task with its own, which begin with `task.`.

    Args:
        settings: `dotted.key=value` each.
    """
    own = [each.strip()[len(PREFIX) :] for each in settings if each.strip().startswith(PREFIX)]
    others = [each for each in settings if not each.strip().startswith(PREFIX)]
    return others, validate(AssemblyConfig, apply_overrides({}, own), source="task assembly")


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


def draw_misalignments(trials: int, seed: int, config: AssemblyConfig) -> list[Misalignment]:
    """Misalignments of a number of trials: in turn beside, at an angle and aligned, in directions drawn evenly."""
    rng = np.random.default_rng([seed, 38])
    kinds: tuple[Kind, ...] = ("offset", "angle", "aligned")
    ranges = {"offset": config.offset_mm, "angle": config.angle_deg, "aligned": (0.0, config.aligned_mm)}
    drawn = []
    for number in range(trials):
        kind, direction = kinds[number % len(kinds)], float(rng.uniform(0, 2 * math.pi))
        x, z = math.cos(direction), math.sin(direction)
        low, high = ranges[kind]
        size = low + float(rng.uniform(0, 1)) * (high - low)
        if kind == "angle":
            drawn.append(Misalignment(kind=kind, tilt_x_deg=size * x, tilt_z_deg=size * z))
        else:
            drawn.append(Misalignment(kind=kind, x_mm=size * x, z_mm=size * z))
    return drawn


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


def timeline(config: AssemblyConfig) -> tuple[Step, ...]:
    """The six stages of one trial."""
    (first_mm, second_mm), (first_n, second_n) = config.insertion_mm, config.push_n
    return (
        Step(stage=TrialStage.GRIP, depth_mm=None),
        Step(stage=TrialStage.APPROACH, depth_mm=-config.before_mm),
        Step(stage=TrialStage.FIRST, depth_mm=first_mm, push_n=first_n),
        Step(stage=TrialStage.SECOND, depth_mm=second_mm, push_n=second_n),
        Step(stage=TrialStage.SUCCESS, depth_mm=config.success_mm, is_aligned=True),
        Step(stage=TrialStage.OPEN, depth_mm=config.success_mm, is_aligned=True),
    )


EARLY = (TrialStage.FIRST, TrialStage.SECOND)
"""Stages in which misalignment is to be noticed."""
BEFORE = TrialStage.APPROACH
"""The stage that they are compared with."""
