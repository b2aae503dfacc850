"""Every number that a configuration file may hold has a smallest and a largest value."""

import importlib
import pkgutil
from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel, TypeAdapter

import magicsim
from magicsim.config.models import Config
from magicsim.detectors.profile import profile_schema

LOWEST, HIGHEST = {"minimum", "exclusiveMinimum"}, {"maximum", "exclusiveMaximum"}
OWN_FILES = {"Manifest", "ShardEntry", "FailedEpisode", "RunIndex", "SweepIndex", "StudyIndex", "TaskIndex"}
"""Written by magicsim alone and checked against the files beside them; a count in them has no largest value."""
NOT_MODELS = (
    "bench",
    "cli",
    "detectors.__main__",
    "__main__",
    "robot.environment",
    "dataset.export",
    "dataset.torch",
    "learn.",
)
"""Modules that need extras or run something; none of them defines a configuration."""


def models() -> list[type[BaseModel]]:
    for module in pkgutil.walk_packages(magicsim.__path__, "magicsim."):
        if not module.name.removeprefix("magicsim.").startswith(NOT_MODELS):
            importlib.import_module(module.name)
    return sorted(set(_below(Config)), key=lambda model: f"{model.__module__}.{model.__name__}")


def _below(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for inner in model.__subclasses__():
        if inner.__module__.startswith("magicsim."):
            yield inner
        yield from _below(inner)


def unbounded(schema: Any, path: str = "") -> Iterator[str]:
    """Where a schema takes any number, however large or small, also inside lists, tuples and alternatives."""
    if isinstance(schema, list):
        for each in schema:
            yield from unbounded(each, path)
    if not isinstance(schema, dict):
        return
    keys = set(schema)
    is_number = schema.get("type") in {"number", "integer"} and not keys & {"const", "enum"}
    if is_number and not (keys & LOWEST and keys & HIGHEST):
        yield path
    for key, inner in schema.items():
        if key in {"properties", "$defs"}:
            for name, field in inner.items():
                yield from unbounded(field, f"{path}.{name}")
        elif key != "default":
            yield from unbounded(inner, path)


@pytest.mark.parametrize("model", models(), ids=lambda model: model.__name__)
def test_every_number_of_a_configuration_has_bounds(model: type[BaseModel]):
    if model.__name__ not in OWN_FILES:
        assert sorted(unbounded(TypeAdapter(model).json_schema())) == []


def test_every_number_of_a_detector_profile_has_bounds():
    assert sorted(unbounded(profile_schema())) == []


@pytest.mark.parametrize(
    ("schema", "found"),
    [
        ({"type": "number", "minimum": 0}, [""]),
        ({"type": "number", "minimum": 0, "exclusiveMaximum": 1}, []),
        ({"properties": {"a": {"prefixItems": [{"type": "integer", "maximum": 3}]}}}, [".a"]),
        ({"properties": {"a": {"anyOf": [{"type": "null"}, {"type": "number"}]}}}, [".a"]),
        ({"$defs": {"B": {"properties": {"a": {"additionalProperties": {"type": "number"}}}}}}, [".B.a"]),
        ({"const": 1, "type": "integer"}, []),
    ],
)
def test_a_number_without_bounds_is_found_wherever_it_stands(schema: dict[str, Any], found: list[str]):
    assert list(unbounded(schema)) == found
