"""A plug that a gripper holds by its handle: what a user writes for it, and the shape it stands for."""

from typing import Literal, Self

from pydantic import model_validator

from magicsim.geometry.objects.rigid_object import EDGE_RADIUS_MM, SHELL_MM, SHELL_SHARE, ObjectBase, Size, check_edge
from magicsim.geometry.shapes.plug import Plug
from magicsim.geometry.shapes.solids import RoundedCylinder, Shape


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
        solid = self.solid()
        return self.entered_from_above(solid, shell_mm=min(SHELL_MM, SHELL_SHARE * solid.feature_mm))

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        check_edge(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)
        if self.pin_radius_mm >= self.radius_mm - self.edge_radius_mm:
            most = self.radius_mm - self.edge_radius_mm
            msg = f"pin_radius_mm = {self.pin_radius_mm:g} is not allowed: must be below the handle's end, {most:g}"
            raise ValueError(msg)
        return self
