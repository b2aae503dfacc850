"""The rigid tool of a Shore A durometer (ASTM D2240, type A): a truncated cone above a flat presser foot."""

from dataclasses import dataclass

import manifold3d
import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.shapes.revolved import Arc, ConvexProfile, Revolved, flat_inset_mm
from magicsim.geometry.shapes.solids import SEGMENTS, around_axis, rounded

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
