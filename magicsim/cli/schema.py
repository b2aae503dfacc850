"""JSON Schema of every kind of configuration file, for editors."""

from typing import Any

from pydantic import TypeAdapter

from magicsim.config.models import NAMED
from magicsim.config.presets import EXPERIMENTS, SCHEMAS, extensions, missing_experiments
from magicsim.dataset.real.description import Description
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.detectors.profile import profile_schema
from magicsim.errors import ConfigError
from magicsim.evaluation.suite import SuiteConfig
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import SceneConfig
from magicsim.sweep.sweep_file import SweepConfig


def schema_of(kind: str) -> dict[str, Any]:
    """JSON Schema of one kind of file, as `magicsim info schema` calls it: `design`, `scene`, ..., `item` or `real`."""
    if kind in extensions(SCHEMAS):
        added: dict[str, Any] = extensions(SCHEMAS)[kind].load()()
        return added
    if kind in EXPERIMENTS:
        raise ConfigError(missing_experiments(kind))
    if kind == "profile":
        return profile_schema()
    models: dict[str, Any] = {
        "design": ElastomerDesign,
        "scene": SceneConfig,
        "rig": Rig,
        "object": ObjectConfig,
        "suite": SuiteConfig,
        "recipe": Recipe,
        "sweep": SweepConfig,
        "real": Description,
    }
    schema = TypeAdapter(models[kind]).json_schema()
    fields = schema.get("properties", {})
    for name in NAMED:
        if name in fields:  # a file may name a preset instead
            fields[name] = {"anyOf": [{"type": "string"}, fields[name]]}
    return schema
