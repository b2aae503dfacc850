"""How a base stands to the plug in each trial: beside its axis, at an angle to it, or aligned."""

import math
from dataclasses import dataclass
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
    """Angle about x [degrees]."""
    tilt_z_deg: float = 0.0
    """Angle about the closing axis [degrees]."""

    @property
    def is_misaligned(self) -> bool:
        """Whether the trial is one that should be noticed."""
        return self.kind != "aligned"


def draw_misalignments(trials: int, seed: int, spread: Spread | None = None) -> list[Misalignment]:
    """Misalignments of a number of trials: in turn aligned, beside and at an angle, in directions drawn evenly.

    Args:
        trials: How many.
        seed: Of the draws.
        spread: Ranges.
    """
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
