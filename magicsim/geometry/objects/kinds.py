"""All kinds of rigid objects that approach and press, and how a user's line or file is read."""

import re
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any, get_args

from pydantic import Field, TypeAdapter

from magicsim.config.models import read_whole, validate
from magicsim.config.named_files import MESH_SUFFIXES
from magicsim.config.presets import find_preset, preset_names
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.objects.everyday import (
    BananaObject,
    MeshObject,
    ScissorsObject,
    ScrewdriverObject,
    SpannerObject,
)
from magicsim.geometry.objects.plain import (
    BoxObject,
    ConeObject,
    CylinderObject,
    DomedCylinderObject,
    PlugObject,
    PunchObject,
    SphereObject,
)
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.geometry.objects.textured import DotsObject, LinesObject

SEQUENCES = frozenset({"size_mm", "color"})
"""Keys whose value may be several numbers."""
_BETWEEN = re.compile(r",(?![^\[]*\])")
"""A comma that is not in brackets."""

AnyObject = (
    SphereObject | CylinderObject | PunchObject | BoxObject | DomedCylinderObject | ConeObject | DotsObject
    | LinesObject | SpannerObject | ScrewdriverObject | ScissorsObject | BananaObject | PlugObject | MeshObject
)  # fmt: skip
ObjectConfig = Annotated[AnyObject, Field(discriminator="kind")]
OBJECT_KINDS: dict[str, type[ObjectBase]] = {
    get_args(kind.model_fields["kind"].annotation)[0]: kind for kind in get_args(AnyObject)
}
"""Every kind by the name that a user writes."""


def parse_object(text: str) -> AnyObject:
    """Reads `KIND:key=value,key=value`, such as `box:size_mm=4x4x8`, or the name of an object preset, such as `orange`.

    Several numbers are written `4x4x8` or, as in TOML, `[4,4,8]`. The name of a mesh may have commas.

    `ConfigError` for an unknown kind, name or key, or a value that is not allowed.
    """
    kind, separator, settings = text.partition(":")
    if not separator and (kind in preset_names("object") or kind.endswith(".toml")) and kind not in OBJECT_KINDS:
        return find_object(kind)
    if kind not in OBJECT_KINDS:
        named = [] if separator else preset_names("object")
        raise ConfigError(unknown_choice("object kind", kind, [*OBJECT_KINDS, *named]))
    values: dict[str, Any] = {"kind": kind}
    given: set[str] = set()
    for setting in _settings(settings, OBJECT_KINDS[kind].model_fields):
        key, separator, value = setting.partition("=")
        if not separator:
            raise ConfigError(f"object '{text}': '{setting}' is not of the form key=value")
        name = key.strip()
        if name in given:
            raise ConfigError(f"object '{text}': {name} is given twice; give it once")
        given.add(name)
        values[name] = _numbers(value) if name in SEQUENCES else value
    model = validate(OBJECT_KINDS[kind], values, source=f"object '{text}'")
    return TypeAdapter(ObjectConfig).validate_python(model)


def _settings(text: str, keys: Collection[str]) -> list[str]:
    """Parts between commas, but for those in the name of a mesh, which ends as meshes do."""
    parts: list[str] = []
    for part in _BETWEEN.split(text):
        key, _, name = parts[-1].partition("=") if parts else ("", "", "")
        if key.strip() == "path" and not name.lower().endswith(MESH_SUFFIXES) and part.partition("=")[0] not in keys:
            parts[-1] += f",{part}"
        elif part:
            parts.append(part)
    return parts


def _numbers(text: str) -> str | list[str]:
    """Parts of `4x4x8` or `[4, 4, 8]`; any other text stays as it is."""
    inner = text.strip()
    if inner.startswith("[") and inner.endswith("]"):
        return [part.strip() for part in inner[1:-1].split(",")]
    return text.split("x") if "x" in text else text


def find_object(name: str | Path) -> AnyObject:
    """An object by preset name, or from the user's own TOML file."""
    path = find_preset("object", name)
    data = read_whole(path)
    kind = str(data.get("kind", ""))
    if kind not in OBJECT_KINDS:
        raise ConfigError(f"{path.name}: {unknown_choice('object kind', kind, OBJECT_KINDS)}")
    return TypeAdapter(ObjectConfig).validate_python(validate(OBJECT_KINDS[kind], data, source=path.name))


def load_object(name: str | Path) -> AnyObject:
    """Reads an object as `--object` takes it: a preset, a TOML file, or a line such as `sphere:radius_mm=4`.

    Raises:
        PresetError: No such preset or file.
        ConfigError: The content is not acceptable.
    """
    return find_object(name) if isinstance(name, Path) else parse_object(name)
