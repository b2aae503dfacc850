"""How a base stands to the plug in each trial: beside its axis, at an angle to it, or aligned."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["aligned", "offset", "angle"]
OFFSET_MM, ANGLE_DEG = (3.0, 6.0), (3.0, 8.0)
"""Ranges of offsets [mm] and angles [degrees]; published are 'above 3 mm' and 'slight angles', the rest is assumed."""
ALIGNED_MM = 0.3
"""Largest offset of a trial that counts as aligned [mm]: the chamfer takes it; assumed."""


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


def draw_misalignments(trials: int, seed: int) -> list[Misalignment]:
    """Misalignments of a number of trials: in turn aligned, beside and at an angle, in directions drawn evenly.

    Args:
        trials: How many.
        seed: Of the draws.
    """
    rng = np.random.default_rng([seed, 38])
    kinds: tuple[Kind, ...] = ("offset", "angle", "aligned")
    drawn = []
    for number in range(trials):
        kind, direction = kinds[number % len(kinds)], float(rng.uniform(0, 2 * math.pi))
        x, z = math.cos(direction), math.sin(direction)
        size = float(rng.uniform(0, 1))
        if kind == "angle":
            angle = ANGLE_DEG[0] + size * (ANGLE_DEG[1] - ANGLE_DEG[0])
            drawn.append(Misalignment(kind=kind, tilt_x_deg=angle * x, tilt_z_deg=angle * z))
        else:
            offset = size * ALIGNED_MM if kind == "aligned" else OFFSET_MM[0] + size * (OFFSET_MM[1] - OFFSET_MM[0])
            drawn.append(Misalignment(kind=kind, x_mm=offset * x, z_mm=offset * z))
    return drawn
