import pytest

from magicsim.detectors import Contact, FrameClass, Proximity, Verdict, score_verdicts
from magicsim.errors import ConfigError

CLEAR, NEAR, CONTACT, LIGHT = FrameClass


def verdict(proximity: Proximity, combined: Contact) -> Verdict:
    return Verdict(
        entropy=0.0,
        correlation=0.0,
        similarity=1.0,
        p_approach=0.0,
        p_noise=0.0,
        p_touch=0.0,
        proximity=proximity,
        contact=Contact.TOUCHED if combined is Contact.UNKNOWN else combined,
        combined=combined,
    )


NORMAL = verdict(Proximity.NORMAL, Contact.UNTOUCHED)
APPROACHING = verdict(Proximity.APPROACHING, Contact.UNTOUCHED)
TOUCHED = verdict(Proximity.APPROACHING, Contact.TOUCHED)
NOISE = verdict(Proximity.NOISE, Contact.UNKNOWN)

FRAMES = [
    *[(NORMAL, CLEAR)] * 3,
    (APPROACHING, CLEAR),
    (APPROACHING, NEAR),
    (TOUCHED, NEAR),
    (NORMAL, NEAR),
    (NOISE, NEAR),
    *[(TOUCHED, CONTACT)] * 2,
    (NOISE, CONTACT),
    (NORMAL, CONTACT),
    (NORMAL, CONTACT),
    *[(NOISE, LIGHT)] * 4,
    (TOUCHED, LIGHT),
    (TOUCHED, None),
    (TOUCHED, None),
]


def score(pairs):
    return score_verdicts([one for one, _ in pairs], [each for _, each in pairs])


def test_proximity_by_hand():
    result = score(FRAMES).proximity
    assert result.row_labels == ("Normal", "Approaching", "Noise")
    assert result.column_labels == ("Normal", "Approaching", "Noise")
    assert result.confusion == ((3, 1, 0), (1, 2, 1), (0, 1, 4))
    assert result.recall == {"Normal": 0.75, "Approaching": 0.5, "Noise": 0.8}
    assert result.accuracy == pytest.approx((0.75 + 0.5 + 0.8) / 3)


def test_contact_by_hand_with_unknown_as_untouched():
    result = score(FRAMES).contact
    assert result.row_labels == ("Clear", "Near", "Contact", "Light")
    assert result.column_labels == ("Touched", "Untouched", "Unknown")
    assert result.confusion == ((0, 4, 0), (1, 2, 1), (2, 2, 1), (1, 0, 4))
    assert result.recall == {"Clear": 1.0, "Near": 0.75, "Contact": 0.4, "Light": 0.8}
    assert result.accuracy == pytest.approx((2 / 5 + 11 / 13) / 2)


def test_frames_are_counted_by_class():
    assert score(FRAMES).frames == {"Clear": 4, "Near": 4, "Contact": 5, "Light": 5, "unscored": 2}


def test_contact_frames_do_not_touch_the_proximity_score():
    without = [pair for pair in FRAMES if pair[1] is not CONTACT]
    assert score(without).proximity == score(FRAMES).proximity


def test_class_without_frames_gives_no_number():
    result = score([pair for pair in FRAMES if pair[1] not in (LIGHT, CONTACT)])
    assert result.proximity.accuracy is None
    assert result.proximity.recall["Noise"] is None
    assert result.proximity.recall["Normal"] == 0.75
    assert result.contact.accuracy is None
    assert result.contact.recall["Contact"] is None


def test_contact_needs_only_one_untouched_class():
    assert score([pair for pair in FRAMES if pair[1] in (CLEAR, CONTACT)]).contact.accuracy == pytest.approx(0.7)


def test_no_frames_give_no_numbers():
    assert score([]).proximity.accuracy is None
    assert score([]).contact.accuracy is None


def test_different_lengths_are_refused():
    with pytest.raises(ConfigError, match="1 verdicts for 2 classes"):
        score_verdicts([NORMAL], [CLEAR, CLEAR])
