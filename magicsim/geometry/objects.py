"""Rigid objects that approach and press: what a user writes for them, and the shape it stands for."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, TypeAdapter, model_validator

from magicsim.config import Config, validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.shapes import RoundedBox, RoundedCylinder, Shape, Sphere

Size = Annotated[float, Field(gt=0.01, le=200)]
Reflectance = Annotated[float, Field(ge=0, le=1)]
EDGE_RADIUS_MM = 0.1
SEQUENCES = frozenset({"size_mm", "color"})
"""Keys whose value may be several numbers, written `4x4x8` on the command line."""


class ObjectBase(Config):
    """What every object has beside its shape."""

    color: tuple[Reflectance, Reflectance, Reflectance] = (0.7, 0.7, 0.7)
    """Diffuse reflectance in linear RGB, 0..1."""
    roll_deg: float = 0.0
    """Rotation about x, applied first [degrees]."""
    pitch_deg: float = 0.0
    """Rotation about y, applied second [degrees]."""
    yaw_deg: float = 0.0
    """Rotation about z, applied last and added to the path's twist [degrees]."""


class SphereObject(ObjectBase):
    """A ball."""

    kind: Literal["sphere"]
    radius_mm: Size

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return Sphere(self.radius_mm)


class CylinderObject(ObjectBase):
    """A cylinder about one axis of its own frame, rims rounded."""

    kind: Literal["cylinder"]
    radius_mm: Size
    length_mm: Size = 20.0
    axis: Literal["x", "y", "z"] = "y"
    edge_radius_mm: Size = EDGE_RADIUS_MM

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return RoundedCylinder(self.radius_mm, self.length_mm, self.axis, self.edge_radius_mm)

    @model_validator(mode="after")
    def _check_rim(self) -> Self:
        _check_edge(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)
        return self


class PunchObject(ObjectBase):
    """A flat punch: a circular face on a shaft along z, its rim rounded."""

    kind: Literal["punch"]
    radius_mm: Size
    length_mm: Size = 10.0
    edge_radius_mm: Size = EDGE_RADIUS_MM

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return RoundedCylinder(self.radius_mm, self.length_mm, "z", self.edge_radius_mm)

    @model_validator(mode="after")
    def _check_rim(self) -> Self:
        _check_edge(self.edge_radius_mm, self.radius_mm, self.length_mm / 2)
        return self


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
        return RoundedBox(self.sizes_mm, self.edge_radius_mm)

    @model_validator(mode="after")
    def _check_edges(self) -> Self:
        _check_edge(self.edge_radius_mm, min(self.sizes_mm) / 2)
        return self


def _check_edge(edge_radius_mm: float, *half_sizes_mm: float) -> None:
    if edge_radius_mm >= min(half_sizes_mm):
        msg = f"edge_radius_mm = {edge_radius_mm:g} is not allowed: must be below {min(half_sizes_mm):g} mm"
        raise ValueError(msg)


ObjectConfig = Annotated[SphereObject | CylinderObject | PunchObject | BoxObject, Field(discriminator="kind")]
OBJECT_KINDS: dict[str, type[ObjectBase]] = {
    "sphere": SphereObject,
    "cylinder": CylinderObject,
    "punch": PunchObject,
    "box": BoxObject,
}


def parse_object(text: str) -> SphereObject | CylinderObject | PunchObject | BoxObject:
    """Reads `KIND:key=value,key=value`, such as `box:size_mm=4x4x8` or `sphere:radius_mm=4`.

    Raises:
        ConfigError: Unknown kind or key, or a value that is not allowed.
    """
    kind, _, settings = text.partition(":")
    if kind not in OBJECT_KINDS:
        raise ConfigError(unknown_choice("object kind", kind, OBJECT_KINDS))
    values: dict[str, Any] = {"kind": kind}
    for setting in filter(None, settings.split(",")):
        key, separator, value = setting.partition("=")
        if not separator:
            msg = f"object '{text}': '{setting}' is not of the form key=value"
            raise ConfigError(msg)
        name = key.strip()
        values[name] = value.split("x") if name in SEQUENCES and "x" in value else value
    model = validate(OBJECT_KINDS[kind], values, source=f"object '{text}'")
    return TypeAdapter(ObjectConfig).validate_python(model)
