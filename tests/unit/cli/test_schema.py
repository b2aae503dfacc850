import re
from typing import Any

import pytest

from magicsim.cli.schema import schema_of
from magicsim.config.documents import read_toml
from magicsim.config.presets import FOLDERS, find_preset, preset_names

KINDS = ("design", "scene", "rig", "object", "recipe", "profile", "suite", "sweep", "real")
TYPES = {
    "object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "boolean": bool,
    "null": type(None),
}  # fmt: skip
KEYWORDS = {
    "$defs", "$ref", "$schema", "additionalProperties", "anyOf", "const", "default", "description", "discriminator",
    "enum", "exclusiveMaximum", "exclusiveMinimum", "items", "maxItems", "maxLength", "maximum", "minItems",
    "minLength", "minimum", "multipleOf", "not", "oneOf", "pattern", "prefixItems", "properties", "required", "title",
    "type",
}  # fmt: skip
"""What the schemas may use: JSON Schema draft 2020-12, and OpenAPI's `discriminator`, which validators ignore."""


def subschemas(schema: dict[str, Any]) -> list[dict[str, Any]]:
    inner = [*schema.get("$defs", {}).values(), *schema.get("properties", {}).values(), *schema.get("prefixItems", [])]
    inner += [*schema.get("anyOf", []), *schema.get("oneOf", [])]
    inner += [schema[key] for key in ("items", "not") if isinstance(schema.get(key), dict)]
    return [schema, *(each for part in inner for each in subschemas(part))]


def accepts(schema: dict[str, Any], value: Any, root: dict[str, Any]) -> bool:
    """A small validator, enough for the keywords above that constrain configuration files."""
    if "$ref" in schema:
        return accepts(root["$defs"][schema["$ref"].removeprefix("#/$defs/")], value, root)
    checks = [
        "type" not in schema
        or (isinstance(value, TYPES[schema["type"]]) and (value is not True or schema["type"] == "boolean")),
        "const" not in schema or value == schema["const"],
        "enum" not in schema or value in schema["enum"],
        "anyOf" not in schema or any(accepts(each, value, root) for each in schema["anyOf"]),
        "oneOf" not in schema or sum(accepts(each, value, root) for each in schema["oneOf"]) == 1,
    ]
    if isinstance(value, str) and "pattern" in schema:
        checks += [re.search(schema["pattern"], value) is not None]
    if isinstance(value, int | float):
        checks += [
            value >= schema.get("minimum", value),
            value <= schema.get("maximum", value),
            "exclusiveMinimum" not in schema or value > schema["exclusiveMinimum"],
            "exclusiveMaximum" not in schema or value < schema["exclusiveMaximum"],
        ]
    if isinstance(value, list):
        checks += [schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))]
        parts = schema.get("prefixItems") or [schema.get("items", {})] * len(value)
        checks += [accepts(part, item, root) for part, item in zip(parts, value, strict=False)]
    if isinstance(value, dict):
        known = schema.get("properties", {})
        checks += [set(schema.get("required", [])) <= set(value)]
        checks += [schema.get("additionalProperties", True) is not False or set(value) <= set(known)]
        checks += [accepts(known[key], item, root) for key, item in value.items() if key in known]
    return all(checks)


@pytest.mark.parametrize("kind", KINDS)
def test_schema_uses_only_keywords_of_its_draft_and_resolves_its_references(kind: str):
    schema = schema_of(kind)
    for each in subschemas(schema):
        assert set(each) <= KEYWORDS
        if "$ref" in each:
            assert each["$ref"].removeprefix("#/$defs/") in schema["$defs"]


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind in FOLDERS for name in preset_names(kind)])
def test_every_shipped_preset_satisfies_its_schema(kind: str, name: str):
    schema = schema_of(kind)
    assert accepts(schema, read_toml(find_preset(kind, name)), schema)


@pytest.mark.parametrize("kind", ["design", "scene", "rig", "object", "recipe", "profile", "suite", "sweep"])
def test_schema_refuses_a_misspelt_key(kind: str):
    schema = schema_of(kind)
    data = read_toml(find_preset(kind, preset_names(kind)[0]))
    assert not accepts(schema, data | {"misspelt": 1}, schema)


def test_schema_names_what_a_design_must_have():
    schema = schema_of("design")
    assert set(schema["required"]) == {"schema_version", "footprint_mm", "skin_mm", "core_mm", "cell_mm", "materials"}
    data = read_toml(find_preset("design", "mini-magictac"))
    assert not accepts(schema, {key: value for key, value in data.items() if key != "skin_mm"}, schema)
    assert not accepts(schema, data | {"skin_mm": -1}, schema)


def test_schema_of_a_scene_allows_a_design_and_a_rig_by_name_or_in_place():
    schema = schema_of("scene")
    data = read_toml(find_preset("scene", "rest"))
    assert accepts(schema, data, schema)
    assert accepts(schema, data | {"design": read_toml(find_preset("design", "mini-magictac"))}, schema)
    assert not accepts(schema, data | {"design": 3}, schema)


def test_schema_of_an_object_tells_kinds_apart():
    schema = schema_of("object")
    assert accepts(schema, {"kind": "sphere", "radius_mm": 4.0}, schema)
    assert accepts(schema, {"kind": "box", "size_mm": [1.0, 2.0, 3.0]}, schema)
    assert not accepts(schema, {"kind": "sphere", "size_mm": 4.0}, schema)
    assert not accepts(schema, {"kind": "pyramid", "size_mm": 4.0}, schema)
