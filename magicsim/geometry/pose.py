"""Where a rigid object is: rotation and position in the sensor's frame."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Object frame to sensor frame: p_sensor = rotation @ p_object + position."""

    position_mm: Array
    """Origin of the object's frame, shape (3,) [mm]."""
    rotation: Array
    """Rotation matrix, shape (3, 3)."""

    def to_sensor(self, points: Array) -> Array:
        """Points from the object's frame to the sensor's, shape (count, 3) [mm]."""
        return points @ self.rotation.T + self.position_mm

    def to_object(self, points: Array) -> Array:
        """Points from the sensor's frame to the object's, shape (count, 3) [mm]."""
        return (points - self.position_mm) @ self.rotation

    def tilted(self, tilt_deg: tuple[float, float]) -> Self:
        """Turned about the origin of the object's frame by a rotation vector along the sensor's x and y [degrees]."""
        if not any(tilt_deg):
            return self
        size = float(np.hypot(*tilt_deg))
        x, y = (each / size for each in tilt_deg)
        sine, cosine = np.sin(np.radians(size)), np.cos(np.radians(size))
        cross = np.array([[0, 0, y], [0, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + sine * cross + (1 - cosine) * cross @ cross  # Rodrigues' formula
        return replace(self, rotation=turn @ self.rotation)

    def key(self) -> tuple[float, ...]:
        """The numbers that define the pose, for comparing and caching."""
        return (*self.position_mm.tolist(), *self.rotation.ravel().tolist())

    @classmethod
    def from_key(cls, key: tuple[float, ...]) -> Self:
        """The pose of a `key`."""
        return cls(position_mm=np.array(key[:3]), rotation=np.array(key[3:]).reshape(3, 3))

    def seen_from(self, other: "Pose") -> Self:
        """This pose in the frame of another one of the same sensor."""
        position = other.to_object(self.position_mm[None])[0]
        return replace(self, position_mm=position, rotation=other.rotation.T @ self.rotation)

    @classmethod
    def from_degrees(cls, position_mm: Array, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Self:
        """Rotations about the fixed axes x (roll), then y (pitch), then z (yaw) [degrees]."""
        angles = np.radians([roll, pitch, yaw])
        (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
        about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        return cls(position_mm=np.asarray(position_mm, float), rotation=about_z @ about_y @ about_x)
