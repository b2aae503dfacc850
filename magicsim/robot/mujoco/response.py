"""What a sensor answers between two solves: linear about the last one.

Wrenches are (force [N], torque [N mm]) on the sensor about its origin in its frame; motions are (shift [mm], rotation
[rad]) of the object's point at the sensor's origin.
"""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.geometry.pose import Pose

LEAST_MM, MOST_MM = 0.005, 0.3
"""Shortest and longest way between two solves [mm]."""
SAFETY, SLOWEST, FASTEST = 0.9, 0.5, 1.5
"""Part of the way that the error allows which is gone, and the least and largest change of it from solve to solve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trust:
    """Way between solves, learned from the errors of the linear answers.

    The error of a linear answer grows with the square of the way, so the way that would have met the tolerance is the
    present one times the root of tolerance over error, as step sizes of differential equations are chosen.
    """

    tolerance_n: float
    """Error of the predicted force that is aimed at [N]."""
    way_mm: float = 0.05
    """Way after which the contact is solved again [mm]."""
    worst_n: float = 0.0
    """Largest error so far [N]."""

    def learned(self, error_n: float) -> Self:
        """After a prediction turned out to be wrong by so much [N]."""
        wanted = SAFETY * math.sqrt(self.tolerance_n / max(error_n, 1e-12))
        way = self.way_mm * min(max(wanted, SLOWEST), FASTEST)
        return replace(self, way_mm=min(max(way, LEAST_MM), MOST_MM), worst_n=max(self.worst_n, error_n))


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """A solved equilibrium and its tangent."""

    pose: Pose
    """Pose of the object when it was solved."""
    wrench: Array
    """Shape (6,)."""
    tangent: Array
    """Derivative of the wrench by the motion, shape (6, 6)."""
    centre_mm: Array
    """Middle of the contact, shape (3,) [mm]."""
    radius_mm: float
    """Radius of a circle of the contact's area [mm]."""

    @classmethod
    def of(cls, pose: Pose, deformation: Deformation, tangent: Array) -> "Response":
        """From a deformation."""
        pressure = deformation.contact_pressure_mpa
        total = float(pressure.sum())
        centre = pressure @ deformation.contact_points_mm / total if total > 0 else np.zeros(3)
        return cls(
            pose=pose,
            wrench=np.concatenate([deformation.force_n, deformation.torque_nmm]),
            tangent=tangent,
            centre_mm=centre,
            radius_mm=float(np.sqrt(deformation.contact_area_mm2 / np.pi)),
        )

    def motion(self, pose: Pose) -> Array:
        """The object's motion since the solve, shape (6,)."""
        turn = pose.rotation @ self.pose.rotation.T
        shift = pose.position_mm - turn @ self.pose.position_mm
        return np.concatenate([shift, Rotation.from_matrix(turn).as_rotvec()])

    def way_mm(self, pose: Pose) -> float:
        """How far the object has moved at the contact since the solve [mm]."""
        motion = self.motion(pose)
        shift = motion[:3] + np.cross(motion[3:], self.centre_mm)
        return float(np.linalg.norm(shift) + self.radius_mm * np.linalg.norm(motion[3:]))

    def predicted(self, pose: Pose) -> Array:
        """The wrench in another pose, shape (6,); zero where the sensor would have to pull."""
        wrench = self.wrench + self.tangent @ self.motion(pose)
        return wrench if wrench[2] > 0 else np.zeros(6)

    @property
    def stiffness(self) -> Array:
        """The symmetric part of the tangent without its negative directions, shape (6, 6)."""
        values, vectors = np.linalg.eigh((self.tangent + self.tangent.T) / 2)
        return np.asarray((vectors * np.maximum(values, 0)) @ vectors.T)
