"""Domed cylinders and cones, which press with their upper end: what a user writes for them, and their shape."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from magicsim.geometry.objects.rigid_object import (
    EDGE_RADIUS_MM,
    REACH_MM,
    SHELL_MM,
    SHELL_SHARE,
    ObjectBase,
    Size,
    check_edge,
)
from magicsim.geometry.shapes.revolved import Revolved, cone, domed_cylinder, flat_inset_mm
from magicsim.geometry.shapes.solids import Shape

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

    @model_validator(mode="after")
    def _check_length(self) -> Self:
        check_edge(self.edge_radius_mm, self.radius_mm)
        least = self.radius_mm + self.edge_radius_mm
        if self.length_mm < least:
            msg = f"length_mm = {self.length_mm:g} is not allowed: must be at least radius and rim, {least:g} mm"
            raise ValueError(msg)
        return self


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

    @model_validator(mode="after")
    def _check_profile(self) -> Self:
        inset = flat_inset_mm(self.half_angle_deg, self.edge_radius_mm)
        if 0 < self.flat_radius_mm <= inset:
            msg = f"flat_radius_mm = {self.flat_radius_mm:g} is not allowed: must be 0 or above {inset:.4g} mm (rim)"
            raise ValueError(msg)
        blunt = self.edge_radius_mm if self.flat_radius_mm > 0 else self.tip_radius_mm
        least = self.edge_radius_mm * (1 + np.sin(np.radians(self.half_angle_deg))) + blunt
        if self.length_mm <= least:
            msg = f"length_mm = {self.length_mm:g} is not allowed: must be above tip and rim, {least:.4g} mm"
            raise ValueError(msg)
        base = self._solid().profile.arcs[0]
        widest = base.radial_mm + base.radius_mm
        if not base.radial_mm > 0 or widest > MAX_RADIUS_MM:
            msg = f"cone: the base would have a radius of {widest:.4g} mm, must be {self.edge_radius_mm:g} to 200 mm"
            raise ValueError(msg)
        return self

    def _solid(self) -> Revolved:
        return cone(
            self.half_angle_deg, self.length_mm, tip_radius_mm=self.tip_radius_mm, flat_radius_mm=self.flat_radius_mm,
            edge_radius_mm=self.edge_radius_mm,
        )  # fmt: skip
