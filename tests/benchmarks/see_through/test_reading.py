"""Shares and ranges of readings whose verdicts are known."""

import pytest
from laboratory.see_through.reading import Reading, features, shares

from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.frame_class import FrameClass


def verdict(similarity: float, proximity: Proximity, contact: Contact) -> Verdict:
    return Verdict(
        entropy=1.0, correlation=0.5, similarity=similarity, p_approach=0.0, p_noise=0.0, p_touch=0.0,
        proximity=proximity, contact=contact, combined=contact, source="",
    )  # fmt: skip


REST = verdict(0.9, Proximity.NORMAL, Contact.UNTOUCHED)
NEAR = verdict(0.8, Proximity.APPROACHING, Contact.UNTOUCHED)
TOUCH = verdict(0.5, Proximity.NORMAL, Contact.TOUCHED)
FALSE_ALARM = verdict(0.4, Proximity.NORMAL, Contact.TOUCHED)


def reading(name: str, clear: list[Verdict]) -> Reading:
    verdicts = [*clear, NEAR, NEAR, TOUCH, TOUCH]
    classes = [FrameClass.CLEAR] * len(clear) + [FrameClass.NEAR] * 2 + [FrameClass.CONTACT] * 2
    return Reading(name=name, lights="dim", classes=tuple(classes), verdicts=tuple(verdicts))


def test_shares_of_right_verdicts():
    found = shares([reading("a", [REST, REST]), reading("b", [REST, FALSE_ALARM])])
    assert found["untouched_called"]["mean"] == pytest.approx(0.25)
    assert found["touched_called"]["mean"] == 1
    assert found["contact_balanced"]["mean"] == pytest.approx((1 + 0.875) / 2)
    assert found["near_balanced"]["mean"] == 1
    assert found["similarity_area"]["mean"] == pytest.approx((1 + 0.75) / 2)
    low, high = found["untouched_called"]["interval"]
    assert low <= 0.25 <= high


def test_features_are_quantiles_of_frames_and_of_sensors():
    found = features([reading("a", [REST, REST]), reading("b", [REST, FALSE_ALARM])])
    assert found["near"]["similarity"]["frames"] == pytest.approx([0.8] * 3)
    assert found["untouched"]["similarity"]["sensors"] == pytest.approx([0.6625, 0.8875])
