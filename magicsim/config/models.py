"""Strict configuration: TOML files and `dotted.key=value` overrides become frozen pydantic models.

Every error is one line that names the file, the field, the value and what is allowed.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from magicsim.config.documents import MAX_DEPTH, parse_toml
from magicsim.config.named_files import read_with_paths
from magicsim.config.presets import find_preset
from magicsim.config.problems import describe_problems
from magicsim.errors import NAME_LENGTH, ConfigError, shortened


class Config(BaseModel):
    """Base of every configuration model: frozen, no unknown keys, finite numbers only."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_flags_for_numbers(cls, data: object) -> object:
        """Pydantic alone would read `true` as 1."""
        for key, value in data.items() if isinstance(data, Mapping) else ():
            parts = value if isinstance(value, list | tuple) else (value,)
            field = cls.model_fields.get(key)
            if field is not None and field.annotation is not bool and any(isinstance(part, bool) for part in parts):
                raise ValueError(f"{key} = {value!r} is not allowed: must not be true or false")
        return data


NAMED = ("design", "rig", "object")
"""Kinds of files that other files name."""
ConfigT = TypeVar("ConfigT", bound=BaseModel)


def load_preset(
    model: type[ConfigT], kind: str, name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None
) -> ConfigT:
    """Reads a preset by name, or a user's TOML file by path, into its model.

    Args:
        model: The configuration model to validate against.
        kind: Kind of preset, a key of `magicsim.config.presets.FOLDERS`.
        name: Preset name or path of a TOML file.
        overrides: `dotted.key=value` settings, the value in TOML or as a bare word; `design.`, `rig.` and `object.`
            reach into the files that this one names.
        seed: Seed instead of the file's.

    Raises:
        PresetError: No such preset or file, or it names a design, rig or object that does not exist.
        ConfigError: The content is not acceptable.
    """
    path = find_preset(kind, name)
    data = read_whole(path, overrides)
    if seed is not None:
        data["seed"] = seed
    return validate(model, data, source=path.name)


def read_whole(path: Path, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Content of a TOML file, with the design, the rig and the object that it names put in place, and with overrides.

    A file that is named by its path is looked for beside this one first.

    Raises:
        PresetError: What it names does not exist.
        ConfigError: A file cannot be read, or an override has the wrong form.
    """
    return in_place(read_with_paths(path), path.parent, overrides)


def in_place(data: Mapping[str, Any], folder: Path, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Content of a file with the design, the rig and the object that it names put in place, and with overrides.

    Args:
        data: What the file holds.
        folder: Where it stands; a file that it names by path is looked for there first.
        overrides: `dotted.key=value` settings.

    Raises:
        PresetError: What it names does not exist.
        ConfigError: A file cannot be read, or an override has the wrong form.
    """
    named = {each: [one for one in overrides if one.partition("=")[0].strip() == each] for each in NAMED}
    result = dict(data)
    for kind, chosen in named.items():
        result = apply_overrides(result, chosen)
        name = result.get(kind)
        if isinstance(name, str):
            local = folder / name
            result[kind] = read_with_paths(
                local if name.endswith(".toml") and local.is_file() else find_preset(kind, name)
            )
    return apply_overrides(result, [one for one in overrides if one.partition("=")[0].strip() not in NAMED])


def apply_overrides(data: Mapping[str, Any], overrides: Sequence[str]) -> dict[str, Any]:
    """Copy of nested tables with `dotted.key=value` settings put in; tables are made where they are missing.

    Raises:
        ConfigError: An override has no `=`, an empty key, goes through something that is not a table, or is nested too
            deeply.
    """
    result = {key: dict(value) if isinstance(value, Mapping) else value for key, value in data.items()}
    for override in overrides:
        key, separator, text = override.partition("=")
        parts = key.strip().split(".")
        if not separator or not all(parts):
            raise ConfigError(f"override '{override}' is not of the form dotted.key=value")
        if len(parts) > MAX_DEPTH:
            msg = f"override '{override}' is nested too deeply: at most {MAX_DEPTH} keys inside each other are allowed"
            raise ConfigError(msg)
        table = result
        for part in parts[:-1]:
            inner = table.get(part, {})
            if not isinstance(inner, Mapping):
                raise ConfigError(f"override '{override}': '{part}' is a value, not a table")
            table[part] = dict(inner)
            table = table[part]
        table[parts[-1]] = _parse_value(text.strip())
    return result


def _parse_value(text: str) -> object:
    """A value in TOML; what is none is a bare word."""
    try:
        table = parse_toml(f"value = {text}", source="the value")
    except ConfigError as error:
        if text[:1] in {"[", "{"}:
            raise ConfigError(f"override value '{shortened(text, NAME_LENGTH)}': {error}") from None
        return text
    return table["value"] if len(table) == 1 else text


def validate(model: type[ConfigT], data: Mapping[str, Any], *, source: str) -> ConfigT:
    """Checks plain data against a model.

    Raises:
        ConfigError: One line about all problems.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ConfigError(f"{source}: {describe_problems(model, error)}") from None
