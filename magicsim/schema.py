"""JSON Schema of every kind of configuration file, for editors."""

from typing import Any

from pydantic import TypeAdapter

from magicsim.dataset.recipe import Recipe
from magicsim.detectors.profile_schema import profile_schema
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects import ObjectConfig
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import SceneConfig


def schema_of(kind: str) -> dict[str, Any]:
    """JSON Schema of `design`, `scene`, `rig`, `object`, `recipe` or `profile`."""
    if kind == "profile":
        return profile_schema()
    models: dict[str, Any] = {
        "design": ElastomerDesign,
        "scene": SceneConfig,
        "rig": Rig,
        "object": ObjectConfig,
        "recipe": Recipe,
    }
    schema = TypeAdapter(models[kind]).json_schema()
    if kind in {"scene", "recipe"}:
        for name in ("design", "rig"):
            schema["properties"][name] = {"anyOf": [{"type": "string"}, schema["properties"][name]]}
    return schema
