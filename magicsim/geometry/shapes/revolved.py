"""Solids of revolution about z that press with their upper end: the domed cylinder and the cone."""

from dataclasses import dataclass

import manifold3d
import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.shapes.profile import Arc, ConvexProfile
from magicsim.geometry.shapes.solids import SEGMENTS, TRIANGLE_MM, around_axis

LEAST_CONE_FEATURE_MM = 0.1
"""A sharper tip of a cone does not ask for finer contact points: its flank carries the load."""


@dataclass(frozen=True, slots=True)
class Revolved:
    """A convex profile turned about the z axis."""

    profile: ConvexProfile
    feature_mm: float

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        radial, outward = around_axis(points[:, :2])
        distance, turned = self.profile.distance(np.stack([radial, points[:, 2]], axis=1))
        return distance, np.concatenate([turned[:, :1] * outward, turned[:, 1:]], axis=1)

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return self.profile.support_mm(float(np.hypot(direction[0], direction[1])), float(direction[2]))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        section = manifold3d.CrossSection([self.profile.polyline()])
        return from_manifold(manifold3d.Manifold.revolve(section, SEGMENTS).refine_to_length(TRIANGLE_MM))


def domed_cylinder(radius_mm: float, length_mm: float, edge_radius_mm: float) -> Revolved:
    """A shaft about the origin whose upper end is a hemisphere.

    Args:
        radius_mm: Of shaft and hemisphere [mm].
        length_mm: From the flat end to the tip [mm], above radius + edge radius.
        edge_radius_mm: Of the rim at the flat end [mm], below the radius.
    """
    half = length_mm / 2
    rim = Arc(
        radial_mm=radius_mm - edge_radius_mm, axial_mm=edge_radius_mm - half, radius_mm=edge_radius_mm, end_deg=0.0
    )
    dome = Arc(radial_mm=0.0, axial_mm=half - radius_mm, radius_mm=radius_mm, end_deg=90.0)
    return Revolved(ConvexProfile((rim, dome)), radius_mm)


def cone(
    half_angle_deg: float,
    length_mm: float,
    *,
    tip_radius_mm: float,
    flat_radius_mm: float,
    edge_radius_mm: float,
) -> Revolved:
    """A cone about the origin with its tip upwards, blunted by a small ball or cut off flat.

    Args:
        half_angle_deg: Between axis and flank [degrees].
        length_mm: From the base to the highest point [mm].
        tip_radius_mm: Of the ball that touches the flank [mm]; not used if the cone is cut off.
        flat_radius_mm: Where the flank meets the plane of the flat end [mm]; 0 for a ball.
        edge_radius_mm: Of the rims of base and flat end [mm].
    """
    angle = np.radians(half_angle_deg)
    half = length_mm / 2
    if flat_radius_mm > 0:
        tip = (flat_radius_mm - flat_inset_mm(half_angle_deg, edge_radius_mm), half - edge_radius_mm, edge_radius_mm)
    else:
        tip = (0.0, half - tip_radius_mm, tip_radius_mm)
    radial, axial, radius = tip
    low = edge_radius_mm - half
    base_radial = radial + ((axial - low) * np.sin(angle) + radius - edge_radius_mm) / np.cos(angle)
    base = Arc(radial_mm=float(base_radial), axial_mm=low, radius_mm=edge_radius_mm, end_deg=half_angle_deg)
    top = Arc(radial_mm=radial, axial_mm=axial, radius_mm=radius, end_deg=90.0)
    return Revolved(ConvexProfile((base, top)), max(flat_radius_mm or tip_radius_mm, LEAST_CONE_FEATURE_MM))


def flat_inset_mm(half_angle_deg: float, edge_radius_mm: float) -> float:
    """How far inside the sharp corner of a flat end the centre of its rounded rim lies [mm]."""
    angle = np.radians(half_angle_deg)
    return float(edge_radius_mm * (1 - np.sin(angle)) / np.cos(angle))
