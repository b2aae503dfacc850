"""An episode's truth, and what a detector says of every frame beside it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.frame_class import FrameClass, classify_frame

Role = Literal["training", "held_out"]
"""Whether the calibration of the shipped profiles may have seen an episode."""
FIRST_PLACE = "own"
"""A suite's own sensor, where no places are given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeTag:
    """Which episode it is. Episodes of one take share everything but the camera's noise."""

    take: str
    """`object/path/light/seed`, or a recording's name."""
    object: str
    role: Role
    path: str
    light: str
    noise: str
    place: str = FIRST_PLACE

    @property
    def name(self) -> str:
        """Unique within a suite."""
        return f"{self.take}/{self.noise}"


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeLabels:
    """Truth of the frames after the references; all arrays have shape (frames,)."""

    gap_mm: Array
    """NaN without an object, negative when pressed."""
    force_n: Array
    flashlight: Mask
    classes: tuple[FrameClass | None, ...]
    """By the rules of `magicsim.frame_class`; None where a frame is not scored."""

    @classmethod
    def of(cls, gap_mm: Array, force_n: Array, flashlight: Mask) -> "EpisodeLabels":
        """EpisodeLabels with their classes."""
        classes = tuple(
            classify_frame(gap_mm=None if np.isnan(gap) else float(gap), force_n=float(force), light_on=bool(light))
            for gap, force, light in zip(gap_mm, force_n, flashlight, strict=True)
        )
        return cls(gap_mm=gap_mm, force_n=force_n, flashlight=flashlight, classes=classes)


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedEpisode:
    """Verdicts and scores of the frames after the references."""

    tag: EpisodeTag
    labels: EpisodeLabels
    proximity: tuple[str, ...]
    contact: tuple[str, ...]
    approach: Array
    """Evidence for a nearby object, shape (frames,)."""
    touch: Array
    """Evidence for a touch, shape (frames,)."""
    features: Mapping[str, Array] = field(default_factory=dict)
    """`entropy`, `correlation` and `similarity` as far as the detector tells them of every frame, shape (frames,)."""
    milliseconds: float = 0.0
    """Median time of one step [ms]; belongs to the machine, so nothing is compared by it."""
    frames_per_second: float = 15.0
