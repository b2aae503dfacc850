"""What acts on a held object beside the fingers: its weight, and an outer force and torque."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number, check_vector
from magicsim.errors import ConfigError
from magicsim.geometry.pose import Pose

SLIPPED_MM = 0.2
"""Way of the skin over the object from which on it is a slip [mm]."""


class Hold(StrEnum):
    """What becomes of the object."""

    PLACED = "placed"
    """It is where its caller put it: a hand or a table takes what the fingers leave out of balance."""
    HELD = "held"
    """It rests between the fingers, in balance with its load."""
    SLIPPED = "slipped"
    """It slid over the skin on its way, and rests again."""
    AWAY = "away"
    """There is none: its caller took it away."""
    DROPPED = "dropped"
    """No friction holds it: it is gone, and the fingers are empty."""

    @property
    def is_empty(self) -> bool:
        """Whether nothing is between the fingers."""
        return self in (Hold.AWAY, Hold.DROPPED)


Vector = tuple[float, float, float]
STANDARD_GRAVITY_M_S2 = 9.80665
MOST_N, MOST_NMM, MOST_MM = 1e4, 1e6, 1e3


@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """Weight and outer wrench of an object, in the gripper's frame."""

    weight_n: float = 0.0
    """Weight [N]."""
    down: Vector = (0.0, -1.0, 0.0)
    """Where gravity points; any length but 0. By default from the fingertips to the motors."""
    centre_mm: Vector = (0.0, 0.0, 0.0)
    """Centre of mass, in the object's own frame [mm]."""
    force_n: Vector = (0.0, 0.0, 0.0)
    """Outer force on the object, such as a hand's that pulls, or that of a socket on a plug [N]."""
    torque_nmm: Vector = (0.0, 0.0, 0.0)
    """Outer torque about the object's origin [N mm]."""

    def __post_init__(self) -> None:
        """Checks the numbers, and that gravity has a direction (`ConfigError`)."""
        check_number("load.weight_n", self.weight_n, 0, MOST_N)
        limits = {"down": MOST_N, "centre_mm": MOST_MM, "force_n": MOST_N, "torque_nmm": MOST_NMM}
        for name, most in limits.items():
            check_vector(f"load.{name}", getattr(self, name), -most, most)
        if not any(self.down):
            raise ConfigError(f"load.down = {list(self.down)} is not allowed: must not be 0")

    @classmethod
    def of_mass(cls, mass_g: float, **other: Vector) -> Self:
        """The load of a mass under standard gravity."""
        return cls(weight_n=mass_g * STANDARD_GRAVITY_M_S2 / 1000, **other)

    def wrench(self, pose: Pose) -> Array:
        """Force [N] and torque about the object's origin [N mm] in the gripper's frame, shape (6,)."""
        down = np.array(self.down) / np.linalg.norm(self.down)
        weight = self.weight_n * down
        torque = np.cross(pose.rotation @ np.array(self.centre_mm), weight) + np.array(self.torque_nmm)
        return np.concatenate([weight + np.array(self.force_n), torque])

    def stiffness(self, pose: Pose) -> Array:
        """How that wrench falls with the object's motion, shape (6, 6) [N/mm, N, N mm]; this one's hardly does."""
        return np.zeros((6, 6))
