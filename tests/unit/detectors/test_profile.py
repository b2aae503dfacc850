import dataclasses
import math

import pytest

from magicsim.detectors import DetectorProfile
from magicsim.errors import ConfigError


def test_defaults_are_the_published_values():
    profile = DetectorProfile()
    assert (profile.tau_e, profile.tau_c, profile.tau_b, profile.tau_g) == (0.5, 0.2, 35, 0.6)
    assert (profile.background_count, profile.reference_count) == (3, 30)
    assert (profile.polarity, profile.similarity, profile.difference_blur_px) == ("dark", "recall", 0)


@pytest.mark.parametrize("each", dataclasses.fields(DetectorProfile), ids=lambda each: each.name)
def test_every_field_says_what_it_means(each):
    assert each.metadata["limits"].about.endswith(".")


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [
        ("tau_e", 8.1, "a number in 0..8"),
        ("tau_e", math.nan, "a number in 0..8"),
        ("tau_c", -math.inf, "a number in -1..1"),
        ("tau_c", "0.2", "a number in -1..1"),
        ("tau_g", True, "a number in 0..1"),
        ("tau_b", 35.0, "a whole number in 0..254"),
        ("tau_b", 255, "a whole number in 0..254"),
        ("grid_blur_px", 4, "an odd whole number in 0..63, or 0 for none"),
        ("polarity", "grey", "one of: dark, bright"),
        ("similarity", ["iou"], "one of: recall, iou, dice"),
        ("background_count", 0, "a whole number in 1..255"),
        ("similarity_width", 0, "a number in 1e-06..1"),
        ("schema_version", 2, "must be 1"),
    ],
)
def test_value_out_of_range_names_field_value_and_what_is_allowed(field, value, allowed):
    with pytest.raises(ConfigError) as caught:
        DetectorProfile(**{field: value})
    assert str(caught.value).startswith(f"{field} = {value!r} ")
    assert allowed in str(caught.value)


def test_whole_number_becomes_float_where_a_float_is_meant():
    assert isinstance(DetectorProfile(tau_e=1).tau_e, float)


def test_fewer_reference_frames_than_backgrounds_are_refused():
    with pytest.raises(ConfigError, match=r"reference_count = 2 .* background_count = 3"):
        DetectorProfile(reference_count=2)


def test_replacing_a_field_checks_it_again():
    with pytest.raises(ConfigError, match="tau_g = 2"):
        dataclasses.replace(DetectorProfile(), tau_g=2.0)
