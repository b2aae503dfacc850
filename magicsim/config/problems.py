"""All that is wrong with a configuration, in one line: each field, its value, what is allowed."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from magicsim.errors import LINE_LENGTH, shortened, unknown_choice

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
    if problem["type"] == "extra_forbidden":
        return ".".join(filter(None, (_written(model, problem["loc"][:-1]), str(problem["loc"][-1]))))
    return _written(model, problem["loc"]) or "the whole"


def _describe(model: type[BaseModel], problem: Mapping[str, Any]) -> str:
    location = _written(model, problem["loc"])
    kind = problem["type"]
    if kind == "extra_forbidden":
        table = _written(model, problem["loc"][:-1])
        valid = _keys_at(model, problem["loc"][:-1])
        key = str(problem["loc"][-1])
        where = "" if table else _below(model, key)
        return unknown_choice(f"key in [{table}]" if table else "key", key, valid) + where
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
    tables = [name for name in model.model_fields if key in _keys_at(model, (name,))]
    return f"; there is {' and '.join(f'{table}.{key}' for table in tables)}" if tables else ""


def _range_at(model: type[BaseModel], location: Sequence[str | int]) -> str:
    """What numbers a field takes; empty where that is not one number's matter."""
    parent: Any = model
    for part in location[:-1]:
        parent = _entered(parent, part)
    field = getattr(_model_in(parent, ""), "model_fields", {}).get(location[-1])
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


def _written(model: type[BaseModel], location: Sequence[str | int]) -> str:
    """Dotted keys as the user writes them, without the names that pydantic adds for members of a union."""
    keys = [
        str(part)
        for place, part in enumerate(location)
        if isinstance(part, int) or part in _keys_at(model, location[:place])
    ]
    return ".".join(keys)


def _keys_at(model: type[BaseModel], location: Sequence[str | int]) -> list[str]:
    """Valid keys of the table at a location, found by walking the model's fields."""
    current: Any = model
    for part in location:
        current = _entered(current, part)
    return list(getattr(_model_in(current, ""), "model_fields", {}))


def _entered(annotation: Any, part: str | int) -> Any:  # noqa: ANN401 - annotations have no common type
    """One step from a table to what is written below it."""
    if isinstance(part, int):
        return annotation
    current = _model_in(annotation, part)
    fields = getattr(current, "model_fields", {})
    return fields[part].annotation if part in fields else current


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
