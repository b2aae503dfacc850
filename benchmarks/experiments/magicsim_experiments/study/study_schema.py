"""JSON Schema of the files of studies, of every kind."""

from typing import Any, Union

from pydantic import TypeAdapter

from magicsim_experiments.study.kinds import KINDS, settings_of
from magicsim_experiments.study.study_file import QUICK

BY_NAME = ("design", "rig", "recipe", "study", "moulded_design")
"""Keys that may give the name of a file instead of its content."""
FROM_ELSEWHERE = {"design", "rig", "moulded_design"}
"""Keys that a file need not have: `--design` or a default gives them."""


def study_schema() -> dict[str, Any]:
    """Any kind of study; what a file may leave out or name, unlike the whole study, is so here."""
    models = tuple(settings_of(kind) for kind in KINDS)
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
