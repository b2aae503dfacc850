"""Balls, cylinders, punches and boxes: what a user writes for them, and the shape it stands for."""

from typing import Literal, Self

from pydantic import model_validator

from magicsim.geometry.objects.rigid_object import EDGE_RADIUS_MM, SHELL_MM, SHELL_SHARE, ObjectBase, Size, check_edge
from magicsim.geometry.shapes.solids import RoundedBox, RoundedCylinder, Shape, Sphere


class SphereObject(ObjectBase):
    """A ball."""

    kind: Literal["sphere"]
    radius_mm: Size

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return Sphere(self.radius_mm)


class RoundObject(ObjectBase):
    """What cylinders and punches have in common: a rounded cylinder."""

    radius_mm: Size
    length_mm: Size
    edge_radius_mm: Size = EDGE_RADIUS_MM

    def _solid(self, axis: Literal["x", "y", "z"]) -> Shape:
        solid = RoundedCylinder(self.radius_mm, self.length_mm, axis, self.edge_radius_mm)
        return self.entered_from_above(solid, shell_mm=min(SHELL_MM, SHELL_SHARE * solid.feature_mm))

    @model_validator(mode="after")
    def _check_rim(self) -> Self:
        check_edge(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)
        return self


class CylinderObject(RoundObject):
    """A cylinder about one axis of its own frame, rims rounded."""

    kind: Literal["cylinder"]
    length_mm: Size = 20.0
    axis: Literal["x", "y", "z"] = "y"

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return self._solid(self.axis)


class PunchObject(RoundObject):
    """A flat punch: a circular face on a shaft along z, its rim rounded."""

    kind: Literal["punch"]
    length_mm: Size = 10.0

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return self._solid("z")


class BoxObject(ObjectBase):
    """A cuboid with rounded edges; one number means a cube."""

    kind: Literal["box"]
    size_mm: Size | tuple[Size, Size, Size]
    edge_radius_mm: Size = EDGE_RADIUS_MM

    @property
    def sizes_mm(self) -> tuple[float, float, float]:
        """Edges along the object's x, y and z [mm]."""
        return self.size_mm if isinstance(self.size_mm, tuple) else (self.size_mm,) * 3

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        solid = RoundedBox(self.sizes_mm, self.edge_radius_mm)
        return self.entered_from_above(solid, shell_mm=min(SHELL_MM, SHELL_SHARE * solid.feature_mm))

    @model_validator(mode="after")
    def _check_edges(self) -> Self:
        check_edge(self.edge_radius_mm, min(self.sizes_mm) / 2)
        return self
