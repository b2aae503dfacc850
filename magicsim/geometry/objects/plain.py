"""Balls, cylinders, punches, boxes, plugs, cones: what a user writes for them, and the shape it stands for.

Domed cylinders and cones press with their upper end.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.rigid_object import (
    EDGE_RADIUS_MM,
    REACH_MM,
    SHELL_MM,
    SHELL_SHARE,
    ObjectBase,
    Size,
    edge_problem,
)
from magicsim.geometry.shapes.revolved import Revolved, cone, domed_cylinder, flat_inset_mm
from magicsim.geometry.shapes.solids import TRIANGLE_MM, RoundedBox, RoundedCylinder, Shape, Sphere


class SphereObject(ObjectBase):
    """A ball."""

    kind: Literal["sphere"]
    radius_mm: Size

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return Sphere(self.radius_mm)


class RoundObject(ObjectBase):
    """A rounded cylinder, as cylinders and punches are."""

    radius_mm: Size
    length_mm: Size
    edge_radius_mm: Size = EDGE_RADIUS_MM

    def _solid(self) -> Shape:
        axis = getattr(self, "axis", "z")
        return RoundedCylinder(self.radius_mm, self.length_mm, axis, self.edge_radius_mm)

    def _problems(self) -> Iterator[str | None]:
        yield edge_problem(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)


class CylinderObject(RoundObject):
    """A cylinder about one axis of its own frame, rims rounded."""

    kind: Literal["cylinder"]
    length_mm: Size = 20.0
    axis: Literal["x", "y", "z"] = "y"


class PunchObject(RoundObject):
    """A flat punch: a circular face on a shaft along z, its rim rounded."""

    kind: Literal["punch"]
    length_mm: Size = 10.0


class BoxObject(ObjectBase):
    """A cuboid with rounded edges; one number means a cube."""

    kind: Literal["box"]
    size_mm: Size | tuple[Size, Size, Size]
    edge_radius_mm: Size = EDGE_RADIUS_MM

    @property
    def sizes_mm(self) -> tuple[float, float, float]:
        """Edges along the object's x, y and z [mm]."""
        return self.size_mm if isinstance(self.size_mm, tuple) else (self.size_mm,) * 3

    def _solid(self) -> Shape:
        return RoundedBox(self.sizes_mm, self.edge_radius_mm)

    def _problems(self) -> Iterator[str | None]:
        yield edge_problem(self.edge_radius_mm, min(self.sizes_mm) / 2)


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
        return np.array([0.0, (self.handle.length_mm + self.pin.length_mm) / 2 - self.handle.edge_radius_mm, 0.0])

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
        whole = self.handle.manifold() + self.pin.manifold().translate(tuple(self.pin_centre_mm))
        return from_manifold(whole.refine_to_length(TRIANGLE_MM))


class PlugObject(ObjectBase):
    """A round handle about its y axis with a pin towards +y."""

    kind: Literal["plug"]
    radius_mm: Size
    """Radius of the handle [mm]."""
    length_mm: Size = 12.0
    """Length of the handle [mm]."""
    edge_radius_mm: Size = 1.0
    """Radius of the handle's rims [mm]."""
    pin_radius_mm: Size = 2.5
    """Radius of the pin [mm]."""
    pin_length_mm: Size = 10.0
    """Length of the pin, from the handle's end [mm]."""

    def solid(self) -> Plug:
        """The exact solid, the handle centred on its origin."""
        handle = RoundedCylinder(self.radius_mm, self.length_mm, "y", self.edge_radius_mm)
        edge = min(EDGE_RADIUS_MM, self.pin_radius_mm / 4)
        return Plug(handle, RoundedCylinder(self.pin_radius_mm, self.pin_length_mm + self.edge_radius_mm, "y", edge))

    def shape(self) -> Shape:
        """The solid with contact by the side of entry."""
        return self.entered_from_above(self.solid())

    def _problems(self) -> Iterator[str | None]:
        yield edge_problem(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)
        most = self.radius_mm - self.edge_radius_mm
        if self.pin_radius_mm >= most:
            yield f"pin_radius_mm = {self.pin_radius_mm:g} is not allowed: must be below the handle's end, {most:g}"


TIP_SHELL_SHARE = 0.5
"""Part of a tip's radius below which contact keeps the nearest feature; nearest features flip below its centre."""
MAX_RADIUS_MM = 200.0


class DomedCylinderObject(ObjectBase):
    """A shaft along z that ends in a hemisphere on top; the rim of its far end is rounded."""

    kind: Literal["domed_cylinder"]
    radius_mm: Size
    length_mm: Size = 20.0
    """From the flat end to the tip [mm]."""
    edge_radius_mm: Size = EDGE_RADIUS_MM

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        solid = domed_cylinder(self.radius_mm, self.length_mm, self.edge_radius_mm)
        return self.entered_from_above(solid, shell_mm=SHELL_SHARE * self.radius_mm)

    def _problems(self) -> Iterator[str | None]:
        yield edge_problem(self.edge_radius_mm, self.radius_mm)
        least = self.radius_mm + self.edge_radius_mm
        if self.length_mm < least:
            yield f"length_mm = {self.length_mm:g} is not allowed: must be at least radius and rim, {least:g} mm"


class ConeObject(ObjectBase):
    """A cone with its tip on top, blunted by a ball, or cut off flat where `flat_radius_mm` is above 0."""

    kind: Literal["cone"]
    half_angle_deg: Annotated[float, Field(ge=1, le=89)]
    """Between axis and flank [degrees]."""
    length_mm: Size = 5.0
    """From the base to the highest point [mm]."""
    tip_radius_mm: Annotated[float, Field(ge=0.01, le=200)] = 0.05
    """Radius of the ball that touches the flank [mm]; not used with a flat end."""
    flat_radius_mm: Annotated[float, Field(ge=0, le=200)] = 0.0
    """Where the flank meets the plane of the flat end [mm]; 0 for a ball."""
    edge_radius_mm: Size = 0.02
    """Radius of the rims of flat end and base [mm]."""

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        # The whole flank faces up, so that the side of entry is right at any depth
        shell = SHELL_SHARE * self.flat_radius_mm or TIP_SHELL_SHARE * self.tip_radius_mm
        return self.entered_from_above(self._solid(), shell_mm=min(SHELL_MM, shell), reach_mm=REACH_MM)

    def _problems(self) -> Iterator[str | None]:
        inset = flat_inset_mm(self.half_angle_deg, self.edge_radius_mm)
        if 0 < self.flat_radius_mm <= inset:
            yield f"flat_radius_mm = {self.flat_radius_mm:g} is not allowed: must be 0 or above {inset:.4g} mm (rim)"
        blunt = self.edge_radius_mm if self.flat_radius_mm > 0 else self.tip_radius_mm
        least = self.edge_radius_mm * (1 + np.sin(np.radians(self.half_angle_deg))) + blunt
        if self.length_mm <= least:
            yield f"length_mm = {self.length_mm:g} is not allowed: must be above tip and rim, {least:.4g} mm"
        base = self._solid().profile.arcs[0]
        widest = base.radial_mm + base.radius_mm
        if not base.radial_mm > 0 or widest > MAX_RADIUS_MM:
            yield f"cone: the base would have a radius of {widest:.4g} mm, must be {self.edge_radius_mm:g} to 200 mm"

    def _solid(self) -> Revolved:
        return cone(
            self.half_angle_deg, self.length_mm, tip_radius_mm=self.tip_radius_mm, flat_radius_mm=self.flat_radius_mm,
            edge_radius_mm=self.edge_radius_mm,
        )  # fmt: skip
