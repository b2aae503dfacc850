import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from magicsim.detectors import DetectorProfile, detect_all, fuse
from magicsim.detectors.combined import detect_from_start, start_stream, step_stream
from magicsim.errors import ConfigError, FrameError

from .conftest import grid_frame, light_frame, near_frame


def noisy(frame, seed):
    return (frame + np.random.default_rng(seed).integers(0, 3, frame.shape)).astype(np.uint8)


@settings(deadline=None, max_examples=20)
@given(
    references=st.integers(3, 8),
    polarity=st.sampled_from(["dark", "bright"]),
    kind=st.sampled_from(["presence", "majority"]),
    seed=st.integers(0, 99),
)
def test_stream_and_batch_give_the_same_verdicts(references, polarity, kind, seed):
    profile = DetectorProfile(reference_count=references, polarity=polarity, grid_reference=kind)
    rest = [noisy(grid_frame(), seed + number) for number in range(references)]
    later = [noisy(grid_frame(), 50), near_frame(), light_frame(), noisy(grid_frame(2), 51)]
    expected = detect_all(later, fuse(rest, profile), profile)
    assert list(detect_from_start([*rest, *later], profile)) == expected
    assert list(detect_from_start(rest, profile)) == []


def test_no_verdict_before_the_references_are_whole(profile):
    state, given_back = start_stream(), []
    for _ in range(profile.reference_count):
        assert state.references is None
        state, verdict = step_stream(state, grid_frame(), profile)
        given_back.append(verdict)
    assert given_back == [None] * profile.reference_count
    assert state.references is not None
    assert state.waiting == ()
    assert step_stream(state, grid_frame(), profile)[1].similarity == 1.0


def test_a_step_changes_neither_the_state_nor_the_frame(profile, references):
    first = start_stream()
    second, _ = step_stream(first, grid_frame(), profile)
    assert (len(first.waiting), len(second.waiting)) == (0, 1)
    ready = start_stream(references)
    frame = near_frame()
    again = [step_stream(ready, frame, profile) for _ in range(2)]
    assert again[0] == again[1]
    assert np.array_equal(frame, near_frame())


def test_a_camera_may_write_over_its_buffer(profile):
    buffer = grid_frame()
    state, _ = step_stream(start_stream(), buffer, profile)
    buffer[:] = 0
    assert np.array_equal(state.waiting[0], grid_frame())


def test_references_from_elsewhere_judge_the_first_frame(profile, references):
    assert step_stream(start_stream(references), near_frame(), profile, source="a.png")[1].source == "a.png"


def test_a_frame_of_another_size_is_refused_and_the_stream_goes_on(profile):
    state, _ = step_stream(start_stream(), grid_frame(), profile)
    with pytest.raises(FrameError, match="like the reference"):
        step_stream(state, grid_frame()[:-1], profile)
    state, _ = step_stream(state, grid_frame(), profile)
    assert len(state.waiting) == 2


def test_another_profile_on_the_way_is_refused(profile, references):
    with pytest.raises(ConfigError, match="grid_reference = 'majority'"):
        step_stream(start_stream(references), near_frame(), dataclasses.replace(profile, grid_reference="majority"))
    with pytest.raises(ConfigError, match=r"grid_blur_sigma_px = 1\.5"):
        step_stream(start_stream(references), near_frame(), dataclasses.replace(profile, grid_blur_sigma_px=1.5))
