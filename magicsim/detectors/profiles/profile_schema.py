"""JSON Schema of the profile files, derived from the dataclass, so that no schema library is needed."""

import dataclasses

from magicsim.detectors.limits import kind_of, limits_of
from magicsim.detectors.profiles.profile import DetectorProfile

_JSON_TYPES = {int: "integer", float: "number", str: "string"}


def profile_schema() -> dict[str, object]:
    """The JSON Schema (draft 2020-12) of a detector profile."""
    properties = {each.name: _property(each) for each in dataclasses.fields(DetectorProfile)}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "DetectorProfile",
        "description": "Thresholds and options of the detectors.",
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _property(each: "dataclasses.Field[object]") -> dict[str, object]:
    """Schema of one field."""
    limits, kind = limits_of(each), kind_of(each)
    entry: dict[str, object] = {
        "type": _JSON_TYPES[kind],
        "description": limits.about,
        "default": each.default,
    }
    if limits.choices:
        return entry | {"enum": list(limits.choices)}
    entry |= {"minimum": limits.low, "maximum": limits.high}
    if limits.odd:
        entry["anyOf"] = [{"const": 0}, {"not": {"multipleOf": 2}}]
    return entry
