"""Rigid objects that approach and press: all kinds that a user may write, and how their line is read."""

from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from magicsim.config import validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.objects_base import ObjectBase
from magicsim.geometry.objects_mesh import MeshObject
from magicsim.geometry.objects_plain import BoxObject, CylinderObject, PunchObject, SphereObject
from magicsim.geometry.objects_pointed import ConeObject, DomedCylinderObject
from magicsim.geometry.objects_textured import DotsObject, LinesObject

__all__ = [
    "OBJECT_KINDS",
    "BoxObject",
    "ConeObject",
    "CylinderObject",
    "DomedCylinderObject",
    "DotsObject",
    "LinesObject",
    "MeshObject",
    "ObjectBase",
    "ObjectConfig",
    "PunchObject",
    "SphereObject",
    "parse_object",
]

SEQUENCES = frozenset({"size_mm", "color"})
"""Keys whose value may be several numbers, written `4x4x8` on the command line."""

AnyObject = (
    SphereObject
    | CylinderObject
    | PunchObject
    | BoxObject
    | DomedCylinderObject
    | ConeObject
    | DotsObject
    | LinesObject
    | MeshObject
)
ObjectConfig = Annotated[AnyObject, Field(discriminator="kind")]
OBJECT_KINDS: dict[str, type[ObjectBase]] = {
    "sphere": SphereObject,
    "cylinder": CylinderObject,
    "punch": PunchObject,
    "box": BoxObject,
    "domed_cylinder": DomedCylinderObject,
    "cone": ConeObject,
    "dots": DotsObject,
    "lines": LinesObject,
    "mesh": MeshObject,
}


def parse_object(text: str) -> AnyObject:
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
