"""Classes of frames follow from what labels tell, directly or not."""

import math

import pytest

from magicsim.dataset.real.description import TruthRules
from magicsim.dataset.real.labels import nothing, truth_of
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass

RULES = TruthRules()


def of(told: set[str], rules: TruthRules = RULES, **labels):
    return truth_of(nothing() | labels, rules, frozenset(told))


def test_nothing_known_is_not_scored():
    found = of(set())
    assert found.frame_class is None
    assert found.contact is None
    assert math.isnan(found.gap_mm)


def test_gap_decides_as_for_simulated_frames():
    assert of({"gap_mm"}).frame_class is FrameClass.CLEAR  # an empty gap is no object
    assert of({"gap_mm"}, gap_mm=2.0).frame_class is FrameClass.NEAR
    assert of({"gap_mm"}, gap_mm=-0.5).frame_class is FrameClass.CONTACT
    assert of({"gap_mm"}, gap_mm=-0.1).frame_class is None  # too light a touch
    assert of({"gap_mm", "flashlight"}, flashlight=True).frame_class is FrameClass.LIGHT


def test_depth_is_a_gap_below_zero():
    found = of({"depth_mm"}, depth_mm=0.6)
    assert (found.gap_mm, found.contact, found.frame_class) == (-0.6, True, FrameClass.CONTACT)
    assert of({"depth_mm"}, depth_mm=0.2).frame_class is None


def test_force_is_contact_of_unknown_depth():
    found = of({"force_n"}, force_n=[0.0, 0.0, 0.4])
    assert (found.contact, found.frame_class) == (True, FrameClass.CONTACT)
    assert math.isnan(found.depth_mm)
    assert of({"force_n"}, force_n=[math.nan, math.nan, -0.4]).contact is True
    free = of({"force_n"}, force_n=[0.0, 0.0, 0.01])
    assert (free.contact, free.frame_class) == (False, None)


def test_frames_without_contact_are_what_the_rules_say():
    rules = TruthRules(without_contact="Clear", contact_n=0.5)
    assert of({"force_n"}, rules, force_n=[0, 0, 0.4]).frame_class is FrameClass.CLEAR


def test_given_class_counts_and_words_are_translated():
    rules = TruthRules(classes={"touch": "Contact", "?": ""})
    assert of({"frame_class"}, rules, frame_class="touch").frame_class is FrameClass.CONTACT
    assert of({"frame_class"}, rules, frame_class="?").frame_class is None
    assert of({"frame_class"}, rules, frame_class="Near", gap_mm=-1.0).frame_class is FrameClass.NEAR
    with pytest.raises(ConfigError, match=r"unknown class 'held'.*truth.classes translates"):
        of({"frame_class"}, rules, frame_class="held")


def test_empty_gap_means_no_object_unless_a_force_or_a_contact_is_left_open():
    alone = of({"gap_mm"})
    assert (alone.frame_class, alone.contact) == (FrameClass.CLEAR, False)
    assert of({"gap_mm", "force_n"}, force_n=[0.0, 0.0, 0.0]).frame_class is FrameClass.CLEAR
    for told in ({"gap_mm", "force_n"}, {"gap_mm", "contact"}):
        assert (of(told).frame_class, of(told).contact) == (None, None)
    assert of({"gap_mm", "force_n"}, force_n=[0.0, 0.0, 2.0]).frame_class is FrameClass.CONTACT
    assert of({"gap_mm"}, is_there=False).frame_class is None


@pytest.mark.parametrize(
    ("force_n", "contact"),
    [([0.0, 0.0, math.nan], None), ([0.3, 0.0, math.nan], True), ([math.nan] * 3, None), ([0.0, 0.0, 0.0], False)],
)
def test_force_with_a_part_that_is_not_known_is_a_contact_or_unknown(force_n, contact):
    found = of({"force_n"}, TruthRules(without_contact="Clear"), force_n=force_n)
    assert found.contact is contact
    assert found.frame_class is {None: None, True: FrameClass.CONTACT, False: FrameClass.CLEAR}[contact]
