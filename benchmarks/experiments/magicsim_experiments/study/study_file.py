"""Reads the file of a study: the small form, the design and the rig put in place, checked."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from magicsim.config.models import apply_overrides, in_place, validate
from magicsim.config.named_files import read_with_paths
from magicsim.config.presets import find_preset, preset_names
from magicsim.errors import ConfigError, unknown_choice
from magicsim_experiments.study.kinds import KINDS, study_class
from magicsim_experiments.study.protocol import Study

DESIGN, RIG = "mini-magictac", "digit-office"
"""What is studied, and what surrounds it, where nothing else is said."""
QUICK = "quick"
"""Table of a study's file with what its small form changes."""


def load_study(
    name: str | Path,
    overrides: Sequence[str] = (),
    *,
    design: str | None = None,
    quick: bool = False,
    seed: int | None = None,
    kinds: Mapping[str, str] | None = None,
) -> Study:
    """Reads a study by preset name or path and looks whether its design can do it.

    Args:
        name: Study preset or TOML file.
        overrides: `dotted.key=value` settings.
        design: Design preset or TOML file instead of the file's.
        quick: Whether to take the small form, the file's table `quick`.
        seed: Seed instead of the file's.
        kinds: Kinds of studies; `KINDS` by default.

    Raises:
        PresetError: The study, or what it names, does not exist.
        ConfigError: The content is not acceptable, or the design cannot do this study.
    """
    path = find_preset("study", name)
    data = without_small_form(read_with_paths(path), source=path.name, quick=quick)
    kind = str(data.get("kind", ""))
    kinds = KINDS if kinds is None else kinds
    if "kind" not in data:
        msg = f"{path.name}: kind is missing; available: {', '.join(sorted(kinds))}"
        raise ConfigError(msg)
    found = study_class(kind, kinds)
    own = data.get("design")
    if design is not None:
        data["design"] = design
    first = [each for each in overrides if "." not in each.partition("=")[0]]
    data = apply_overrides(data, first)
    if isinstance(own, Mapping) and isinstance(data.get("design"), str) and not _is_set("name", first):
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


def _is_set(key: str, overrides: Sequence[str]) -> bool:
    return any(each.partition("=")[0].strip() == key for each in overrides)


def without_small_form(data: Mapping[str, Any], *, source: str, quick: bool) -> dict[str, Any]:
    """Content of a study's file with its table `quick` put over the rest, or left out.

    Raises:
        ConfigError: That is no table.
    """
    rest = {key: value for key, value in data.items() if key != QUICK}
    small = data.get(QUICK, {})
    if not isinstance(small, Mapping):
        msg = f"{source}: {QUICK} = {small!r} is not allowed: must be a table"
        raise ConfigError(msg)
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
        kind: Kind of preset.
        folder: Where the naming file stands.

    Raises:
        PresetError: There is no such file.
        ConfigError: It cannot be read, or the value is neither.
    """
    if isinstance(value, Mapping):
        return dict(value)
    if not isinstance(value, str):
        raise ConfigError(unknown_choice(kind, str(value), preset_names(kind)))
    beside = folder / value
    return read_with_paths(beside if value.endswith(".toml") and beside.is_file() else find_preset(kind, value))
