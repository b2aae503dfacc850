"""The jack: a round hole with a chamfer in a flat base, as a signed distance.

Its frame has the hole's axis along +y, into the base, and its origin in the middle of the mouth. The base is the half
space y > 0 without the hole.
"""

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from magicsim.arrays import Array
from magicsim.config.ranges import check_number
from magicsim.geometry.pose import Pose

LIMITS = {"radius_mm": (0.05, 100.0), "chamfer_mm": (0.0, 50.0), "depth_mm": (0.1, 200.0)}
FAR_MM = 1e4
"""How far the base reaches [mm]."""
TINY = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class Jack:
    """Numbers of the hole; all are assumed."""

    radius_mm: float = 2.6
    """Radius of the hole [mm]: 0.1 mm more than the default plug's pin."""
    chamfer_mm: float = 0.5
    """Chamfer of the mouth, at 45 degrees [mm]."""
    depth_mm: float = 12.0
    """Depth of the hole [mm]."""

    def __post_init__(self) -> None:
        """Checks the numbers."""
        for field in fields(self):
            check_number(f"jack.{field.name}", getattr(self, field.name), *LIMITS[field.name])

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance to the base, negative inside of it, and the outward normal, exact.

        Args:
            points: In the jack's frame, shape (points, 3) [mm].

        Returns:
            Shapes (points,) [mm] and (points, 3).
        """
        radial = np.hypot(points[:, 0], points[:, 2])
        outward = np.stack([points[:, 0], points[:, 2]], 1) / np.maximum(radial, TINY)[:, None]
        places = np.stack([radial, points[:, 1]], 1)
        corners = self._profile()
        best, foot = np.full(len(points), np.inf), np.zeros_like(places)
        normal = np.zeros_like(places)
        for first, last in pairwise(corners):
            way = last - first
            length = float(np.linalg.norm(way))
            if length < TINY:
                continue
            share = np.clip((places - first) @ way / length**2, 0, 1)
            nearest = first + share[:, None] * way
            away = np.linalg.norm(places - nearest, axis=1)
            closer = away < best
            best[closer], foot[closer] = away[closer], nearest[closer]
            normal[closer] = np.array([way[1], -way[0]]) / length
        inside = places[:, 1] > self._surface(places[:, 0])
        signed = np.where(inside, -best, best)
        offset = (places - foot) * np.where(inside, -1.0, 1.0)[:, None]
        is_on = best < TINY
        turned = np.where(is_on[:, None], normal, offset / np.maximum(best, TINY)[:, None])
        full = np.stack([turned[:, 0] * outward[:, 0], turned[:, 1], turned[:, 0] * outward[:, 1]], 1)
        return signed, full

    def _profile(self) -> Array:
        """Corners of the base's surface in the half plane (radial, axial), from far away to the hole's bottom [mm]."""
        radius, chamfer = self.radius_mm, self.chamfer_mm
        return np.array(
            [[FAR_MM, 0.0], [radius + chamfer, 0.0], [radius, chamfer], [radius, self.depth_mm], [0.0, self.depth_mm]]
        )

    def _surface(self, radial: Array) -> Array:
        """Height of the surface at a distance from the axis [mm]."""
        flank = self.radius_mm + self.chamfer_mm - radial
        return np.asarray(np.where(radial < self.radius_mm, self.depth_mm, np.clip(flank, 0.0, None)))


def jack_pose(*, mouth_mm: tuple[float, float, float], tilt_x_deg: float = 0.0, tilt_z_deg: float = 0.0) -> Pose:
    """From the jack's frame to the gripper's.

    Args:
        mouth_mm: Middle of the mouth in the gripper's frame [mm].
        tilt_x_deg: Rotation of the base about x [degrees].
        tilt_z_deg: Then about z [degrees].
    """
    return Pose.from_degrees(np.array(mouth_mm), roll=tilt_x_deg, yaw=tilt_z_deg)
