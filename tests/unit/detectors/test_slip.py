import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.detectors import DetectorProfile, Proximity
from magicsim.detectors.combined import judge
from magicsim.detectors.grasp import SlipState, is_touch_lost, step_slip

PROFILE = DetectorProfile(tau_g=0.8, slip_share=0.25, slip_window=2, touch_hysteresis=0.5)  # lost from S = 0.9


def slips(levels, profile=PROFILE, entropies=None):
    """Frames at which a slip is seen; a level is S, or None for a frame under outside light with S = 1."""
    state, found = SlipState(), []
    for number, level in enumerate(levels):
        entropy = 3.0 if entropies is None else entropies[number]
        verdict = judge(
            entropy=entropy,
            correlation=0.9 if level is None else 0.1,
            similarity=1.0 if level is None else level,
            profile=profile,
        )
        assert (verdict.proximity is Proximity.NOISE) == (level is None)
        state, slipped = step_slip(state, verdict, profile)
        found += [number] * slipped
    return found


def test_quarter_of_what_was_lost_coming_back_at_once_is_a_slip():
    assert slips([0.5, 0.5, 0.625]) == [2]
    assert slips([0.5, 0.5, 0.6249]) == []


def test_rise_within_the_window_is_a_slip_and_a_slower_one_is_not():
    assert slips([0.5, 0.5625, 0.625]) == [2]
    slow = [0.60, 0.63, 0.66, 0.69, 0.72, 0.75]
    assert slips(slow) == []
    assert slips(slow, dataclasses.replace(PROFILE, slip_window=4)) == [4, 5]


def test_falling_similarity_is_a_firmer_grip():
    assert slips([0.79, 0.6, 0.4, 0.1]) == []


def test_slowly_lost_touch_is_a_slip_once_it_is_above_the_hysteresis():
    assert slips([0.80, 0.82, 0.84, 0.86, 0.88, 0.90], dataclasses.replace(PROFILE, slip_window=1)) == [5]


def test_light_that_comes_and_goes_is_no_slip():
    assert slips([0.5, None, None, 0.89, 0.89]) == []


def test_no_rise_is_measured_across_light():
    assert slips([0.5, None, 0.7, 0.7, 0.7]) == []
    assert slips([0.5, 0.5, 0.7, 0.7]) == [2, 3]


def test_object_lost_under_light_is_seen_in_the_second_frame_after_it():
    assert slips([0.5, None, 1.0, 1.0]) == [3]


def test_similarity_and_entropy_that_rise_together_are_light_on_the_held_object():
    assert slips([0.5, 0.7, 0.7, 0.5], entropies=[3.0, 3.2, 3.3, 3.0]) == []
    assert slips([0.5, 0.7, 0.7, 0.5], entropies=[3.0, 3.1, 3.1, 3.0]) == [1, 2]
    assert slips([0.5, 0.95, 0.95, 0.95, 0.5], entropies=[3.0, 4.0, 4.0, 4.0, 3.0]) == []


def test_rise_of_entropy_is_measured_from_the_frame_before():
    assert slips([0.5, 0.5, 0.7], entropies=[4.0, 3.0, 3.5]) == []
    assert slips([0.5, 0.5, 0.7], entropies=[3.0, 4.0, 3.5]) == [2]


def test_similarity_that_rises_while_entropy_falls_is_a_slip():
    assert slips([0.5, 0.7], entropies=[3.0, 1.0]) == [1]


def test_object_lost_under_light_that_was_no_noise_is_seen_two_frames_after_it():
    assert slips([0.5, 0.95, 0.95, 0.95, 0.95], entropies=[3.0, 4.0, 4.0, 1.0, 1.0]) == [4]


def test_history_begins_anew_when_the_light_on_the_held_object_goes():
    assert slips([0.5, 0.7, 0.7, 0.7, 0.8], entropies=[3.0, 4.0, 3.1, 3.1, 3.1]) == [4]


def test_firmer_grip_raises_entropy_and_is_no_light():
    assert slips([0.5, 0.4, 0.3, 0.5], entropies=[3.0, 3.5, 4.0, 2.0]) == [3]


def test_unchanged_similarity_of_one_is_only_a_lost_touch():
    whole = dataclasses.replace(PROFILE, tau_g=1.0)
    assert slips([1.0, 1.0], whole) == [0, 1]
    assert is_touch_lost(1.0, whole)


@pytest.mark.parametrize(("similarity", "lost"), [(0.85, False), (0.899, False), (0.9, True), (1.0, True)])
def test_touch_is_lost_at_the_upper_threshold(similarity, lost):
    assert is_touch_lost(similarity, PROFILE) is lost


@given(levels=st.lists(st.one_of(st.none(), st.floats(0, 0.89)), max_size=20), window=st.integers(1, 5))
def test_no_slip_at_a_frame_of_light_or_the_one_after(levels, window):
    for frame in slips(levels, dataclasses.replace(PROFILE, slip_window=window)):
        assert levels[frame] is not None
        assert frame > 0
        assert levels[frame - 1] is not None


@given(levels=st.lists(st.floats(0, 0.89), min_size=1, max_size=20), scale=st.floats(0.01, 1))
def test_share_does_not_depend_on_how_far_the_similarity_falls(levels, scale):
    """Squeezing all levels towards 1 changes no verdict: it is the share that counts."""
    open_ended = dataclasses.replace(PROFILE, tau_g=1.0, touch_hysteresis=1.0, slip_share=0.3)
    squeezed = [1 - scale * (1 - level) for level in levels]
    rises = [(b - min(levels[max(0, k - 1) : k + 1])) / (1 - min(levels[max(0, k - 1) : k + 1]))
             for k, b in enumerate(levels[1:])]  # fmt: skip
    if all(abs(rise - 0.3) > 1e-6 for rise in rises):
        assert slips(squeezed, open_ended) == slips(levels, open_ended)
