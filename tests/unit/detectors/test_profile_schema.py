import dataclasses

from magicsim.detectors import DetectorProfile, profile_schema


def test_schema_has_exactly_the_profile_fields_and_forbids_others():
    schema = profile_schema()
    assert list(schema["properties"]) == [each.name for each in dataclasses.fields(DetectorProfile)]
    assert schema["additionalProperties"] is False


def test_schema_carries_type_range_default_and_choices():
    properties = profile_schema()["properties"]
    assert properties["tau_c"]["type"] == "number"
    assert (properties["tau_c"]["minimum"], properties["tau_c"]["maximum"]) == (-1.0, 1.0)
    assert properties["tau_b"] == {
        "type": "integer",
        "description": "Grey level that separates grid from background; above is bright.",
        "default": 35,
        "minimum": 0,
        "maximum": 254,
    }
    assert properties["similarity"]["enum"] == ["recall", "iou", "dice"]
    assert {"not": {"multipleOf": 2}} in properties["grid_blur_px"]["anyOf"]
