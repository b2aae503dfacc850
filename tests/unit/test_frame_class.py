import math

import pytest

from magicsim.detectors import FrameClass, classify_frame
from magicsim.errors import ConfigError
from magicsim.frame_class import LIGHT_TOUCH, frame_label, scored_class


@pytest.mark.parametrize(
    ("gap_mm", "force_n", "light_on", "expected"),
    [
        (None, 0.0, False, FrameClass.CLEAR),
        (None, 0.0, True, FrameClass.LIGHT),
        (3.0001, 0.0, False, None),
        (3.0, 0.0, False, FrameClass.NEAR),
        (0.0501, 0.0, False, FrameClass.NEAR),
        (0.05, 0.0, False, None),
        (0.0, 0.0, False, None),
        (-0.299, 1.0, False, None),
        (-0.3, 1.0, False, FrameClass.CONTACT),
        (0.9 - 1.2, 1.0, False, FrameClass.CONTACT),
        (-0.3, 0.0, False, None),
        (-2.0, 5.0, True, FrameClass.CONTACT),
        (1.0, 0.0, True, FrameClass.NEAR),
        (10.0, 0.0, True, None),
    ],
)
def test_class_at_the_boundaries(gap_mm, force_n, light_on, expected):
    assert classify_frame(gap_mm=gap_mm, force_n=force_n, light_on=light_on) is expected


@pytest.mark.parametrize("gap_mm", [None, 1.0, -1.0])
def test_reference_frames_are_never_scored(gap_mm):
    assert classify_frame(gap_mm=gap_mm, force_n=1.0, light_on=True, is_reference=True) is None


@pytest.mark.parametrize("values", [{"gap_mm": math.nan}, {"gap_mm": None, "force_n": math.inf}])
def test_truth_that_is_not_finite_is_refused(values):
    with pytest.raises(ConfigError, match="finite"):
        classify_frame(**values)


def test_every_touch_has_a_label_and_a_light_one_is_not_scored():
    for gap_mm, force_n, label in ((-0.2, 0.1, LIGHT_TOUCH), (-0.2, 0.0, ""), (-0.4, 0.1, "Contact"), (0.02, 0.0, "")):
        found = classify_frame(gap_mm=gap_mm, force_n=force_n)
        assert frame_label(found, touches=force_n > 0) == label
        assert scored_class(label) is found
    with pytest.raises(ConfigError, match=r"unknown class 'Touch'.*Light touch"):
        scored_class("Touch")
