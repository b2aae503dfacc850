"""Reads the file of a study: the small form, the design and the rig put in place, checked."""

import importlib
import importlib.metadata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Union, cast

from pydantic import TypeAdapter

from magicsim.config.models import apply_overrides, in_place, validate
from magicsim.config.named_files import read_with_paths
from magicsim.config.presets import find_preset, preset_names
from magicsim.errors import ConfigError, unknown_choice
from magicsim_experiments.learn.settings import need_packages
from magicsim_experiments.study.protocol import Study

BY_NAME = ("design", "rig", "recipe", "study", "moulded_design")
"""Keys that may give the name of a file instead of its content."""
FROM_ELSEWHERE = {"design", "rig", "moulded_design"}
"""Keys that a file need not have: `--design` or a default gives them."""


def study_schema() -> dict[str, Any]:
    """Any kind of study; what a file may leave out or name, unlike the whole study, is so here."""
    models = tuple(study_class(kind).settings for kind in KINDS)
    union: Any = Union[models]  # noqa: UP007 - of a list
    schema: dict[str, Any] = TypeAdapter(union).json_schema()
    settings = {model.__name__ for model in models}
    tables = [table for name, table in schema.get("$defs", {}).items() if name in settings]
    for table in tables or [schema]:
        properties = table["properties"]
        for name in BY_NAME:
            if name in properties:
                properties[name] = {"anyOf": [{"type": "string"}, properties[name]]}
        if "others" in properties:  # names, or tables that leave out what the first design gives
            properties["others"] = {"type": "array", "items": {"anyOf": [{"type": "string"}, {"type": "object"}]}}
        if "rigs" in properties:
            properties["rigs"] = {"anyOf": [{"type": "array", "items": {"type": "string"}}, properties["rigs"]]}
        properties["study_changes"] = {"type": "object", "description": "Keys of the compared study that change."}
        properties[QUICK] = {"type": "object", "description": "What --quick changes."}
        properties["recipe_changes"] = {"type": "object", "description": "Keys of the recipe that this study changes."}
        table["required"] = [name for name in table.get("required", []) if name not in FROM_ELSEWHERE]
    return schema


KINDS: dict[str, str] = {
    "alignment": "magicsim_experiments.study.learned.alignment:Alignment",
    "compare": "magicsim_experiments.study.compare:Compare",
    "deformation-law": "magicsim_experiments.study.mechanics.deformation_law:DeformationLaw",
    "fusion": "magicsim_experiments.study.fusion:Fusion",
    "light-modes": "magicsim_experiments.study.lighting.light_modes:LightModes",
    "limits": "magicsim_experiments.study.mechanics.limits:Limits",
    "localisation": "magicsim_experiments.study.learned.localisation:Localisation",
    "manufacturing": "magicsim_experiments.study.mechanics.manufacturing:Manufacturing",
    "ranging": "magicsim_experiments.study.learned.ranging:Ranging",
    "resolution": "magicsim_experiments.study.learned.resolution:Resolution",
    "wear": "magicsim_experiments.study.learned.wear:Wear",
}
"""Kind of a study, as its file names it, and `module:class` of what does it."""


def study_class(kind: str, kinds: Mapping[str, str] | None = None) -> type[Study]:
    """The class of a kind of study, which a file's key `kind` names, among kinds (`KINDS` by default)."""
    kinds = KINDS if kinds is None else kinds
    if kind not in kinds:
        raise ConfigError(unknown_choice("kind of study", kind, kinds))
    module, _, name = kinds[kind].partition(":")
    return cast("type[Study]", getattr(importlib.import_module(module), name))


def package_versions(study: Study) -> dict[str, str]:
    """Versions of the packages that a study needs beside those of the program."""
    need_packages(study.packages, f"study '{study.config.kind}'")
    return {name: importlib.metadata.version(name) for name in study.packages}


DESIGN, RIG = "mini-magictac", "digit-office"
"""What is studied, and what surrounds it, where nothing else is said."""
QUICK = "quick"
"""Table of a study's file with what its small form changes."""


def load_study(
    name: str | Path, overrides: Sequence[str] = (), *, design: str | None = None, quick: bool = False,
    seed: int | None = None, kinds: Mapping[str, str] | None = None,
) -> Study:  # fmt: skip
    """Reads a study by preset name or path and looks whether its design can do it.

    Args:
        overrides: `dotted.key=value` settings.
        design: Design preset or TOML file instead of the file's.
        quick: Whether to take the small form, the file's table `quick`.
        seed: Seed instead of the file's.
        kinds: Kinds of studies; `KINDS` by default.

    Raises:
        ConfigError: The content is not acceptable, or the design cannot do this study.
    """
    path = find_preset("study", name)
    data = without_small_form(read_with_paths(path), source=path.name, quick=quick)
    kind = str(data.get("kind", ""))
    kinds = KINDS if kinds is None else kinds
    if "kind" not in data:
        raise ConfigError(f"{path.name}: kind is missing; available: {', '.join(sorted(kinds))}")
    found = study_class(kind, kinds)
    own = data.get("design")
    if design is not None:
        data["design"] = design
    first = [each for each in overrides if "." not in each.partition("=")[0]]
    data, set_here = apply_overrides(data, first), {each.partition("=")[0].strip() for each in first}
    if isinstance(own, Mapping) and isinstance(data.get("design"), str) and "name" not in set_here:
        data = found.settings.of_another_design(data)
    data.setdefault("design", DESIGN)
    if "rig" not in data:
        data["rig"] = usual_rig(data["design"])
    data = found.settings.completed(data, folder=path.parent, quick=quick)
    data = in_place(data, path.parent, [each for each in overrides if each not in first])
    if seed is not None:
        data["seed"] = seed
    study = found(validate(found.settings, data, source=path.name))
    study.refuse()
    return study


def without_small_form(data: Mapping[str, Any], *, source: str, quick: bool) -> dict[str, Any]:
    """Content of a study's file with its table `quick` put over the rest, or left out."""
    rest = {key: value for key, value in data.items() if key != QUICK}
    small = data.get(QUICK, {})
    if not isinstance(small, Mapping):
        raise ConfigError(f"{source}: {QUICK} = {small!r} is not allowed: must be a table")
    return merged(rest, small) if quick else rest


def merged(data: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Nested tables with those of another put over them; anything else is replaced whole."""
    result = dict(data)
    for key, value in changes.items():
        inner = result.get(key)
        result[key] = merged(inner, value) if isinstance(inner, Mapping) and isinstance(value, Mapping) else value
    return result


def usual_rig(design: object) -> str:
    """Name of the rig that a design is used with: that of the scene with its name, else `digit-office`."""
    if isinstance(design, str) and design in preset_names("scene"):
        return str(read_with_paths(find_preset("scene", design)).get("rig", RIG))
    return RIG


def named_table(value: object, kind: str, folder: Path) -> dict[str, Any]:
    """A table that a file may name instead of holding it.

    Args:
        value: The table, a preset's name, or a file, which is looked for beside the naming one first.
        folder: Where the naming file stands.
    """
    if isinstance(value, Mapping):
        return dict(value)
    if not isinstance(value, str):
        raise ConfigError(unknown_choice(kind, str(value), preset_names(kind)))
    beside = folder / value
    return read_with_paths(beside if value.endswith(".toml") and beside.is_file() else find_preset(kind, value))
