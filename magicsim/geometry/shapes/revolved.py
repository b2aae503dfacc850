"""Solids of revolution about z that press with their upper end: the domed cylinder and the cone.

Their profile is convex: arcs joined by tangent segments, from the lower end of the axis to its upper end,
counter-clockwise in (radial, axial) coordinates. Its outward normal turns from -90 to +90 degrees without jumps, so
that the sign of the nearest piece is always right.

The rigid tool of a Shore A durometer (ASTM D2240, type A) is a truncated cone above a flat presser foot.
"""

from dataclasses import dataclass
from functools import lru_cache

import manifold3d
import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.shapes.solids import SEGMENTS, TRIANGLE_MM, around_axis, rounded

LEAST_CONE_FEATURE_MM = 0.1
"""A sharper tip of a cone does not ask for finer contact points: its flank carries the load."""
SHORT_MM = 1e-12
"""Segments below this length are left out [mm]."""
ARC_STEP_DEG = 11.25
"""Largest angle between neighbouring points of a small arc [degrees]."""
FINE_STEP_DEG = 2.8125
"""Largest angle between points of arcs of at least `LARGE_MM`: 128 points on a full circle [degrees]."""
LARGE_MM = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Arc:
    """Part of a circle, from the previous piece's normal to the next one's."""

    radial_mm: float
    """Distance of the centre from the axis [mm], not negative."""
    axial_mm: float
    """Height of the centre [mm]."""
    radius_mm: float
    """Radius of the arc [mm]."""
    end_deg: float
    """Angle of the outward normal at the upper end, from the radial direction [degrees]; 90 for the last arc."""


@dataclass(frozen=True, slots=True)
class ConvexProfile:
    """Arcs from the lower to the upper end; neighbours must share a tangent line at their common normal."""

    arcs: tuple[Arc, ...]

    def distance(self, places: Array) -> tuple[Array, Array]:
        """Signed distance [mm] and outward unit normal, exact on both sides, of radius and height, (count, 2)."""
        best, normal, start = np.full(len(places), np.inf), np.zeros_like(places), -90.0
        for arc in self.arcs:
            offset = places - (arc.radial_mm, arc.axial_mm)
            length = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
            angle = np.degrees(np.arctan2(offset[:, 1], offset[:, 0]))
            signed = np.where((angle >= start) & (angle <= arc.end_deg), length - arc.radius_mm, np.inf)
            _keep_nearer(best, normal, signed, offset / np.maximum(length, SHORT_MM)[:, None])
            start = arc.end_deg
        for first, last, outward in _segments(self):
            along = np.array([-outward[1], outward[0]])
            offset = places - first
            foot = np.clip(offset @ along, 0, np.linalg.norm(last - first))
            beside = offset - foot[:, None] * along
            signed = np.copysign(np.sqrt(beside[:, 0] ** 2 + beside[:, 1] ** 2), offset @ outward)
            _keep_nearer(best, normal, signed, outward)
        return best, normal

    def support_mm(self, radial: float, axial: float) -> float:
        """Largest extent along a direction of the half plane, radial not negative [mm]."""
        angle = np.degrees(np.arctan2(axial, radial))
        arc = next(arc for arc in self.arcs if angle <= arc.end_deg)
        return arc.radial_mm * radial + arc.axial_mm * axial + arc.radius_mm * float(np.hypot(radial, axial))

    def polyline(self) -> Array:
        """Points on the profile with both ends on the axis, shape (points, 2) [mm]."""
        points, start = [], -90.0
        for arc in self.arcs:
            step = FINE_STEP_DEG if arc.radius_mm >= LARGE_MM else ARC_STEP_DEG
            count = 1 + max(1, int(np.ceil((arc.end_deg - start) / step - 1e-9)))
            angles = np.radians(np.linspace(start, arc.end_deg, count))
            centre = (arc.radial_mm, arc.axial_mm)
            points.append(centre + arc.radius_mm * np.stack([np.cos(angles), np.sin(angles)], axis=1))
            start = arc.end_deg
        inner = np.concatenate(points)
        low, high = inner[[0, -1]] * [0, 1]
        return np.concatenate([low[None], inner[inner[:, 0] > SHORT_MM], high[None]])


@lru_cache(maxsize=64)
def _segments(profile: ConvexProfile) -> list[tuple[Array, Array, Array]]:
    """Start, end and outward normal of the straight pieces."""
    starts = np.radians([-90.0, *(arc.end_deg for arc in profile.arcs)])
    normals = np.stack([np.cos(starts), np.sin(starts)], axis=1)
    centres = np.array([[arc.radial_mm, arc.axial_mm] for arc in profile.arcs])
    radii = np.array([[arc.radius_mm] for arc in profile.arcs])
    enters, leaves = centres + radii * normals[:-1], centres + radii * normals[1:]
    firsts = np.concatenate([enters[:1] * [0, 1], leaves])
    lasts = np.concatenate([enters, leaves[-1:] * [0, 1]])
    pieces = zip(firsts, lasts, normals, strict=True)
    return [(a, b, normal) for a, b, normal in pieces if np.linalg.norm(b - a) > SHORT_MM]


def _keep_nearer(best: Array, normal: Array, signed: Array, candidate: Array) -> None:
    """Replaces, in place, what a piece of smaller unsigned distance beats."""
    nearer = np.abs(signed) < np.abs(best)
    np.copyto(best, signed, where=nearer)
    np.copyto(normal, candidate, where=nearer[:, None])


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
    """A shaft about the origin whose upper end is a hemisphere; the rim of its flat end is rounded."""
    half = length_mm / 2
    rim = Arc(
        radial_mm=radius_mm - edge_radius_mm, axial_mm=edge_radius_mm - half, radius_mm=edge_radius_mm, end_deg=0.0
    )
    dome = Arc(radial_mm=0.0, axial_mm=half - radius_mm, radius_mm=radius_mm, end_deg=90.0)
    return Revolved(ConvexProfile((rim, dome)), radius_mm)


def cone(
    half_angle_deg: float, length_mm: float, *, tip_radius_mm: float, flat_radius_mm: float, edge_radius_mm: float
) -> Revolved:
    """A cone about the origin with its tip upwards, blunted by a small ball or cut off flat (see `ConeObject`)."""
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


TIP_RADIUS_MM = 0.395
"""Radius of the flat end [mm]."""
HALF_ANGLE_DEG = 17.5
"""Between axis and flank [degrees]."""
SHAFT_RADIUS_MM = 0.625
"""Radius of the shaft behind the cone [mm]."""
EDGE_RADIUS_MM = 0.03
"""Radius of the tip's and the hole's edges [mm]; the standard calls them sharp."""
LENGTH_MM = 6.0
"""From the tip to the hidden end of the shaft [mm]."""
FOOT_RADIUS_MM = 9.0
"""Radius of the presser foot [mm]."""


@dataclass(frozen=True, slots=True)
class DurometerTool:
    """Cone with its tip at the origin, pointing to +z, and the foot's plane `extension_mm` below it."""

    extension_mm: float
    hole_radius_mm: float | None
    """Radius of the hole in the foot [mm]; None for no foot."""

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return TIP_RADIUS_MM

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        distance, normal = TIP.distance(points + np.array([0.0, 0.0, LENGTH_MM / 2]))
        if self.hole_radius_mm is None:
            return distance, normal
        foot, outward = self._foot(points)
        nearer = foot < distance
        return np.where(nearer, foot, distance), np.where(nearer[:, None], outward, normal)

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`; of the cone alone."""
        return TIP.support_mm(direction) - LENGTH_MM / 2 * float(direction[2])

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`; of the cone alone."""
        section = manifold3d.CrossSection([TIP.profile.polyline() - [0.0, LENGTH_MM / 2]])
        return from_manifold(manifold3d.Manifold.revolve(section, SEGMENTS))

    def _foot(self, points: Array) -> tuple[Array, Array]:
        """A ring of infinite depth, its inner edge rounded."""
        radial, outward = around_axis(points[:, :2])
        inner = (self.hole_radius_mm or 0.0) + EDGE_RADIUS_MM
        offset = np.stack([inner - radial, points[:, 2] + self.extension_mm + EDGE_RADIUS_MM], axis=1)
        distance, turned = rounded(offset)
        distance = distance - EDGE_RADIUS_MM
        beyond = radial - FOOT_RADIUS_MM
        normal = np.concatenate([-turned[:, :1] * outward, turned[:, 1:]], axis=1)
        normal = np.where((beyond > 0)[:, None], [0.0, 0.0, 1.0], normal)
        return np.where(beyond > 0, np.maximum(beyond, distance), distance), normal


def _tip() -> Revolved:
    """The profile, centred on its own middle: rim of the hidden end, shoulder between shaft and cone, tip."""
    angle, edge, half = np.radians(HALF_ANGLE_DEG), EDGE_RADIUS_MM, LENGTH_MM / 2
    inset = flat_inset_mm(HALF_ANGLE_DEG, edge)
    tip = Arc(radial_mm=TIP_RADIUS_MM - inset, axial_mm=half - edge, radius_mm=edge, end_deg=90.0)
    radial = SHAFT_RADIUS_MM - edge
    height = tip.axial_mm - (radial - tip.radial_mm) / float(np.tan(angle))
    shoulder = Arc(radial_mm=radial, axial_mm=height, radius_mm=edge, end_deg=HALF_ANGLE_DEG)
    rim = Arc(radial_mm=radial, axial_mm=edge - half, radius_mm=edge, end_deg=0.0)
    return Revolved(ConvexProfile((rim, shoulder, tip)), TIP_RADIUS_MM)


TIP = _tip()
