"""A plug: a round handle with a pin on its axis."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.shapes.solids import TRIANGLE_MM, RoundedCylinder


@dataclass(frozen=True, slots=True)
class Plug:
    """Two cylinders about the y axis, the handle centred on the origin, the pin from its upper end; rims rounded.

    Distances are exact outside; inside, the depth below the part that reaches deeper.
    """

    handle: RoundedCylinder
    pin: RoundedCylinder

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`; the handle's, which fingers press."""
        return self.handle.feature_mm

    @property
    def pin_centre_mm(self) -> Array:
        """Middle of the pin's cylinder, which begins a rim's radius inside the handle, shape (3,) [mm]."""
        overlap = self.handle.edge_radius_mm
        return np.array([0.0, (self.handle.length_mm + self.pin.length_mm) / 2 - overlap, 0.0])

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        handle, outward = self.handle.distance(points)
        pin, beside = self.pin.distance(points - self.pin_centre_mm)
        is_pin = pin < handle
        return np.where(is_pin, pin, handle), np.where(is_pin[:, None], beside, outward)

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        pin = self.pin.support_mm(direction) + float(self.pin_centre_mm @ direction)
        return max(self.handle.support_mm(direction), pin)

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        handle = self.handle.manifold()
        whole = handle + self.pin.manifold().translate(tuple(self.pin_centre_mm))
        return from_manifold(whole.refine_to_length(TRIANGLE_MM))
