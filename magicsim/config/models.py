"""Strict configuration: TOML files and `dotted.key=value` overrides become frozen pydantic models.

Every error is one line: the file, and all that is wrong with it, each field, its value, what is allowed.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from magicsim.config.documents import MAX_DEPTH, parse_toml
from magicsim.config.named_files import read_with_paths
from magicsim.config.presets import expanded, find_preset, is_file
from magicsim.errors import LINE_LENGTH, NAME_LENGTH, ConfigError, shortened, unknown_choice

NUMERIC = ("int_", "float_", "greater_than", "less_than")
"""How pydantic's kinds of problems with a number begin."""
ROOM = LINE_LENGTH - 80
"""Longest account of all problems before the rest is told by its keys alone: the name of the file comes before it."""
KEY_LENGTH = 24
"""Room for each key [characters]."""
CALLED = {"tuple_type": "list", "list_type": "list", "dict_type": "table", "model_type": "table"}
"""What pydantic's kinds are in TOML."""
BOUNDS = {"ge": "of at least", "gt": "above", "le": "at most", "lt": "below"}


def describe_problems(model: type[BaseModel], error: ValidationError) -> str:
    """All problems, unknown keys before others: in full as long as the line allows, then by their keys."""
    errors = error.errors(include_url=False)
    problems = [each for each in errors if not _follows(each, errors)]
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")
    line = _describe(model, problems[0])
    for place, problem in enumerate(problems[1:], 1):
        longer = f"{line}; {_describe(model, problem)}"
        if len(longer) > ROOM - KEY_LENGTH * (len(problems) - place - 1):
            keys = (_key(model, each) for each in problems[place:])
            return f"{line}; also wrong: {', '.join(keys)}"
        line = longer
    return line


def _follows(problem: Mapping[str, Any], others: Sequence[Mapping[str, Any]]) -> bool:
    """Whether a list is too short only because its entries are wrong, of which each is told itself."""
    place = problem["loc"]
    return problem["type"] == "too_short" and any(
        len(each["loc"]) > len(place) and each["loc"][: len(place)] == place for each in others
    )


def _key(model: type[BaseModel], problem: Mapping[str, Any]) -> str:
    table, _ = _walked(model, problem["loc"][:-1])
    if problem["type"] == "extra_forbidden":
        return f"{table}.{problem['loc'][-1]}".lstrip(".")
    return _walked(model, problem["loc"])[0] or "the whole"


def _describe(model: type[BaseModel], problem: Mapping[str, Any]) -> str:
    location, _ = _walked(model, problem["loc"])
    kind = problem["type"]
    if kind == "extra_forbidden":
        table, annotation = _walked(model, problem["loc"][:-1])
        key = str(problem["loc"][-1])
        where = "" if table else _below(model, key)
        return unknown_choice(f"key in [{table}]" if table else "key", key, _fields_in(annotation)) + where
    if kind == "missing":
        return f"{location} is missing"
    if kind == "union_tag_not_found":
        return f"{location}.kind is missing"
    if kind == "union_tag_invalid":
        tags = [tag.strip(" '") for tag in problem["ctx"]["expected_tags"].split(",")]
        return unknown_choice(f"{location}.kind", problem["ctx"]["tag"], tags)
    reason = _reason(problem)
    if kind == "value_error":
        return f"{location}: {reason}" if location else reason
    allowed = _range_at(model, problem["loc"]) if kind.startswith(NUMERIC) else ""
    value = shortened(repr(problem["input"]), LINE_LENGTH // 2)
    return f"{location} = {value} is not allowed: {allowed or reason[0].lower() + reason[1:]}"


def _reason(problem: Mapping[str, Any]) -> str:
    """What is wrong with a value, in the words of TOML."""
    if problem["type"] in CALLED:
        return f"must be a {CALLED[problem['type']]}"
    if problem["type"] == "too_short":
        return f"must hold at least {problem['ctx']['min_length']}"
    return str(problem["msg"]).removeprefix("Value error, ").replace("Input should be", "must be", 1)


def _below(model: type[BaseModel], key: str) -> str:
    """Where an unknown key would be known: in a table of the model."""
    tables = [name for name, field in model.model_fields.items() if key in _fields_in(field.annotation)]
    return f"; there is {' and '.join(f'{table}.{key}' for table in tables)}" if tables else ""


def _range_at(model: type[BaseModel], location: Sequence[str | int]) -> str:
    """What numbers a field takes; empty where that is not one number's matter."""
    field = _fields_in(_walked(model, location[:-1])[1]).get(location[-1])
    if field is None:
        return ""
    members = (field.annotation, *getattr(field.annotation, "__args__", ()))
    kinds = {getattr(each, "__origin__", each) for each in members}
    if not kinds & {int, float}:
        return ""
    inner = [each for member in members for info in getattr(member, "__metadata__", ()) for each in info.metadata]
    bounds = [
        f"{word} {getattr(bound, name):g}"
        for bound in (*field.metadata, *inner)
        for name, word in BOUNDS.items()
        if getattr(bound, name, None) is not None
    ]
    number = "number" if float in kinds else "whole number"
    return f"must be a {number} {' and '.join(bounds)}".rstrip()


def _walked(model: type[BaseModel], location: Sequence[str | int]) -> tuple[str, Any]:
    """Dotted keys as the user writes them, without pydantic's names for members of a union, and what stands there."""
    keys: list[str] = []
    current: Any = model
    for part in location:
        if isinstance(part, int):
            keys.append(str(part))
        elif (field := _fields_in(current, part).get(part)) is not None:
            keys.append(part)
            current = field.annotation
        else:
            current = _model_in(current, part)
    return ".".join(keys), current


def _fields_in(annotation: Any, tag: str = "") -> dict[Any, Any]:  # noqa: ANN401 - annotations have no common type
    """Fields of the model inside an annotation, by name."""
    return getattr(_model_in(annotation, tag), "model_fields", {})


def _model_in(annotation: Any, tag: str) -> Any:  # noqa: ANN401 - annotations have no common type
    """The model inside `list[Model]`, `Model | None` or a tagged union (by its tag)."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    candidates = [_model_in(inner, tag) for inner in getattr(annotation, "__args__", ())]
    models = [inner for inner in candidates if isinstance(inner, type) and issubclass(inner, BaseModel)]
    for candidate in models:
        kind = candidate.model_fields.get("kind")
        if kind is not None and tag in getattr(kind.annotation, "__args__", ()):
            return candidate
    return models[0] if models else annotation


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

    @model_validator(mode="after")
    def _refuse_problems(self) -> Self:
        for problem in filter(None, self._problems()):
            raise ValueError(problem)
        return self

    def _problems(self) -> Iterable[str | None]:
        """What is not allowed of values together: the first is told. Each may rely on those before; None is none."""
        return ()


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

    A path that the file names starts beside it, one of an override in the current folder; the other folder is second.
    """
    return in_place(read_with_paths(path), path.parent, overrides, typed_in=Path())


def in_place(
    data: Mapping[str, Any], folder: Path, overrides: Sequence[str] = (), *, typed_in: Path | None = None
) -> dict[str, Any]:
    """Content of a file, as `read_whole`, from what it holds and the folder where it stands.

    Files that overrides name are looked for in `typed_in` first, by default beside the file as others are.
    """
    named = {each: [one for one in overrides if one.partition("=")[0].strip() == each] for each in NAMED}
    result = dict(data)
    for kind, chosen in named.items():
        result = apply_overrides(result, chosen)
        name = result.get(kind)
        if isinstance(name, str):
            places = [typed_in, folder] if chosen and typed_in is not None else [folder]
            paths = [place / expanded(name) for place in places if name.endswith(".toml")]
            result[kind] = read_with_paths(next(filter(is_file, paths), None) or find_preset(kind, name))
    return apply_overrides(result, [one for one in overrides if one.partition("=")[0].strip() not in NAMED])


def apply_overrides(data: Mapping[str, Any], overrides: Sequence[str]) -> dict[str, Any]:
    """Copy of nested tables with `dotted.key=value` settings put in; tables are made where they are missing.

    `ConfigError` where an override has no `=`, an empty key, goes through what is no table, or is nested too deeply.
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
    """Checks plain data against a model; a `ConfigError` has all problems in one line."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ConfigError(f"{source}: {describe_problems(model, error)}") from None
