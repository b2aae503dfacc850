"""Convex profiles of solids of revolution: arcs joined by tangent segments, with exact distances in the half plane.

A profile runs from the lower end of the axis to its upper end, counter-clockwise in (radial, axial) coordinates. Its
outward normal turns from -90 to +90 degrees without jumps, so that the sign of the nearest piece is always right.
"""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array

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
        """Signed distance, shape (count,) [mm], and outward unit normal, shape (count, 2), exact on both sides.

        Args:
            places: Radial and axial coordinates, radial not negative, shape (count, 2) [mm].
        """
        best = np.full(len(places), np.inf)
        normal = np.zeros_like(places)
        start = -90.0
        for arc in self.arcs:
            offset = places - (arc.radial_mm, arc.axial_mm)
            length = np.linalg.norm(offset, axis=1)
            angle = np.degrees(np.arctan2(offset[:, 1], offset[:, 0]))
            signed = np.where((angle >= start) & (angle <= arc.end_deg), length - arc.radius_mm, np.inf)
            _keep_nearer(best, normal, signed, offset / np.maximum(length, SHORT_MM)[:, None])
            start = arc.end_deg
        for first, last, outward in self._segments():
            along = np.array([-outward[1], outward[0]])
            offset = places - first
            foot = np.clip(offset @ along, 0, np.linalg.norm(last - first))
            beside = np.linalg.norm(offset - foot[:, None] * along, axis=1)
            signed = np.copysign(beside, offset @ outward)
            _keep_nearer(best, normal, signed, np.broadcast_to(outward, places.shape))
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

    def _segments(self) -> list[tuple[Array, Array, Array]]:
        """Start, end and outward normal of the straight pieces."""
        starts = np.radians([-90.0, *(arc.end_deg for arc in self.arcs)])
        normals = np.stack([np.cos(starts), np.sin(starts)], axis=1)
        centres = np.array([[arc.radial_mm, arc.axial_mm] for arc in self.arcs])
        radii = np.array([[arc.radius_mm] for arc in self.arcs])
        enters, leaves = centres + radii * normals[:-1], centres + radii * normals[1:]
        firsts = np.concatenate([enters[:1] * [0, 1], leaves])
        lasts = np.concatenate([enters, leaves[-1:] * [0, 1]])
        pieces = zip(firsts, lasts, normals, strict=True)
        return [(a, b, normal) for a, b, normal in pieces if np.linalg.norm(b - a) > SHORT_MM]


def _keep_nearer(best: Array, normal: Array, signed: Array, candidate: Array) -> None:
    """Replaces, in place, what a piece of smaller unsigned distance beats."""
    nearer = np.abs(signed) < np.abs(best)
    best[nearer] = signed[nearer]
    normal[nearer] = candidate[nearer]
