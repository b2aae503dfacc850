import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.detectors import Contact, DetectorProfile, Proximity, detect, detect_all, detect_stream
from magicsim.detectors.combined import combine, judge, logistic
from magicsim.errors import ConfigError, FrameError

from .conftest import grid_frame, light_frame, near_frame


def test_untouched_frame_is_normal_and_untouched(references, profile):
    verdict = detect(grid_frame(), references, profile)
    assert (verdict.entropy, verdict.correlation, verdict.similarity) == (0.0, 0.0, 1.0)
    assert (verdict.proximity, verdict.contact, verdict.combined) == (
        Proximity.NORMAL,
        Contact.UNTOUCHED,
        Contact.UNTOUCHED,
    )


def test_near_object_approaches_without_touch(references, profile):
    verdict = detect(near_frame(), references, profile)
    assert verdict.proximity is Proximity.APPROACHING
    assert verdict.combined is Contact.UNTOUCHED
    assert verdict.p_approach > 0.9


def test_darkened_ground_is_no_approach_and_lost_lines_are_a_touch(references, profile):
    frame = np.full_like(grid_frame(), 80)
    frame[:24] = grid_frame()[:24]
    verdict = detect(frame, references, profile)
    assert verdict.combined is (Contact.UNKNOWN if verdict.proximity is Proximity.NOISE else Contact.TOUCHED)
    assert verdict.contact is Contact.TOUCHED


def test_flashlight_is_noise_and_therefore_no_touch(references, profile):
    verdict = detect(light_frame(), references, profile)
    assert verdict.proximity is Proximity.NOISE
    assert verdict.contact is Contact.TOUCHED
    assert verdict.combined is Contact.UNKNOWN
    assert verdict.p_noise > 0.9


@pytest.mark.parametrize("contact", [Contact.TOUCHED, Contact.UNTOUCHED])
@pytest.mark.parametrize("proximity", list(Proximity))
def test_combined_is_unknown_exactly_under_noise(proximity, contact):
    assert combine(proximity, contact) is (Contact.UNKNOWN if proximity is Proximity.NOISE else contact)


def test_batch_and_stream_equal_a_loop(references, profile):
    frames = [grid_frame(), near_frame(), light_frame()]
    expected = [detect(frame, references, profile) for frame in frames]
    assert detect_all(frames, references, profile) == expected
    assert list(detect_stream(iter(frames), references, profile)) == expected


def test_probability_is_one_half_at_the_threshold(profile):
    at = judge(entropy=0.5, correlation=-1.0, similarity=0.6, profile=profile)
    assert at.p_approach == pytest.approx(0.5)
    assert at.p_touch == pytest.approx(0.5)
    assert judge(entropy=8.0, correlation=0.2, similarity=1.0, profile=profile).p_noise == pytest.approx(0.5)


def test_probabilities_are_logistic_in_the_named_widths(profile):
    wide = dataclasses.replace(profile, entropy_width=2.0, correlation_width=0.4, similarity_width=0.1)
    verdict = judge(entropy=2.5, correlation=0.6, similarity=0.5, profile=wide)
    one = 1 / (1 + np.exp(-1))
    assert verdict.p_noise == pytest.approx(one * one)
    assert verdict.p_approach == pytest.approx(one * (1 - one))
    assert verdict.p_touch == pytest.approx(one)


def test_logistic_never_overflows():
    assert (logistic(-1e9), logistic(0.0), logistic(1e9)) == (0.0, 0.5, 1.0)


def test_references_of_other_options_are_refused(references, profile):
    other = dataclasses.replace(profile, tau_b=50)
    with pytest.raises(ConfigError, match=r"tau_b = 50.*35"):
        detect(grid_frame(), references, other)


def test_thresholds_may_change_after_fusion(references, profile):
    strict = dataclasses.replace(profile, tau_e=7.9)
    assert detect(near_frame(), references, strict).proximity is Proximity.NORMAL


@pytest.mark.parametrize(
    "frame",
    [
        grid_frame()[:-1],
        grid_frame()[..., 0],
        grid_frame().astype(float),
        np.full(grid_frame().shape, np.nan),
    ],
)
def test_unusable_frame_raises_instead_of_a_verdict(frame, references, profile):
    with pytest.raises(FrameError):
        detect(frame, references, profile)


def test_verdict_is_ready_for_json(references, profile):
    row = json.loads(json.dumps(detect(grid_frame(), references, profile).as_dict()))
    assert list(row) == [
        *("entropy", "correlation", "similarity", "p_approach", "p_noise", "p_touch"),
        *("proximity", "contact", "combined"),
    ]
    assert row["proximity"] == "Normal"
    assert detect(grid_frame(), references, profile, source="a.png").as_dict()["source"] == "a.png"


def probabilities(entropy, correlation, similarity):
    verdict = judge(entropy=entropy, correlation=correlation, similarity=similarity, profile=DetectorProfile())
    return np.array([verdict.p_approach, verdict.p_noise, verdict.p_touch])


@given(
    entropy=st.tuples(st.floats(0, 8), st.floats(0, 8)).map(sorted),
    correlation=st.tuples(st.floats(-1, 1), st.floats(-1, 1)).map(sorted),
    similarity=st.tuples(st.floats(0, 1), st.floats(0, 1)).map(sorted),
)
def test_probabilities_are_monotone_and_shares(entropy, correlation, similarity):
    e, c, s = entropy[0], correlation[0], similarity[0]
    low, more_e = probabilities(e, c, s), probabilities(entropy[1], c, s)
    more_c, more_s = probabilities(e, correlation[1], s), probabilities(e, c, similarity[1])
    assert (more_e - low >= -1e-15).tolist() == [True, True, True]
    assert more_e[2] == low[2]
    assert more_c[0] <= low[0] + 1e-15
    assert more_c[1] >= low[1] - 1e-15
    assert more_c[2] == low[2]
    assert more_s[2] <= low[2]
    assert (more_s[:2] == low[:2]).all()
    assert (low >= 0).all()
    assert low[0] + low[1] <= 1 + 1e-15


@given(entropy=st.floats(0, 8), correlation=st.floats(-1, 1), similarity=st.floats(0, 1))
def test_a_probability_above_one_half_has_its_verdict(entropy, correlation, similarity):
    verdict = judge(entropy=entropy, correlation=correlation, similarity=similarity, profile=DetectorProfile())
    if verdict.p_approach > 0.5 + 1e-9:
        assert verdict.proximity is Proximity.APPROACHING
    if verdict.p_noise > 0.5 + 1e-9:
        assert verdict.proximity is Proximity.NOISE
    assert (verdict.contact is Contact.TOUCHED) or verdict.p_touch <= 0.5 + 1e-9


def test_references_that_were_fused_with_other_options_are_refused(profile, references):
    with pytest.raises(ConfigError, match="grid_reference = 'majority'"):
        detect(near_frame(), references, dataclasses.replace(profile, grid_reference="majority"))
    with pytest.raises(ConfigError, match=r"grid_blur_sigma_px = 1\.5"):
        detect(near_frame(), references, dataclasses.replace(profile, grid_blur_sigma_px=1.5))
