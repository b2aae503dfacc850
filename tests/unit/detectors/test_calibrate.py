import dataclasses
import math

import numpy as np
import pytest

from detectors.conftest import ROWS, grid_frame, light_frame, near_frame
from magicsim.detectors import (
    Candidates,
    DetectorProfile,
    Episode,
    FrameClass,
    detect_all,
    fit_profile,
    fuse,
    load_profile,
    score_verdicts,
)
from magicsim.detectors.calibrate import held_out_accuracy, sharpen
from magicsim.errors import ConfigError

BASE = DetectorProfile(reference_count=4, tau_e=7.9, tau_c=-0.9, tau_g=0.01)
SMALL = Candidates(tau_b=(5, 35), grid_blur_px=(5, 0), difference_blur_px=(3, 0))


def pressed_frame(seed: int) -> np.ndarray:
    """The lower two thirds of the grid lose their lines; every channel brightens elsewhere."""
    frame = near_frame(seed)
    start = ROWS // 3
    frame[start:] = 80 + np.random.default_rng(seed).integers(0, 60, frame[start:].shape)
    return frame


def make_episode(seed: int) -> Episode:
    rng = np.random.default_rng(seed)

    def jitter(frame: np.ndarray) -> np.ndarray:
        return (frame + (rng.random(frame.shape) < 0.1)).astype(np.uint8)

    makers = {
        FrameClass.CLEAR: lambda _: grid_frame(),
        FrameClass.NEAR: near_frame,
        FrameClass.CONTACT: pressed_frame,
        FrameClass.LIGHT: light_frame,
    }
    pairs = [(jitter(make(10 * seed + k)), each) for each, make in makers.items() for k in range(3)]
    return Episode(
        references=[jitter(grid_frame()) for _ in range(4)],
        frames=[frame for frame, _ in pairs],
        classes=[each for _, each in pairs],
    )


EPISODES = [make_episode(1), make_episode(2)]


def accuracies(profile, episodes):
    verdicts, classes = [], []
    for episode in episodes:
        verdicts += detect_all(episode.frames, fuse(episode.references, profile), profile)
        classes += episode.classes
    result = score_verdicts(verdicts, classes)
    return result.proximity.accuracy, result.contact.accuracy


def test_separable_episodes_are_told_apart_also_in_new_frames():
    fitted = fit_profile(BASE, EPISODES, SMALL)
    assert fitted.best.accuracy == 1.0
    assert fitted.best.proximity_margin > 0
    assert fitted.best.contact_margin > 0
    assert accuracies(fitted.profile, EPISODES) == (1.0, 1.0)
    assert accuracies(fitted.profile, [make_episode(3)]) == (1.0, 1.0)
    assert accuracies(BASE, EPISODES) != (1.0, 1.0)


def test_every_candidate_reports_what_detection_then_scores():
    fitted = fit_profile(BASE, EPISODES, SMALL)
    assert len(fitted.candidates) == 2 * 2 * 3 * 2 * 2
    for each in fitted.candidates[:: len(fitted.candidates) // 7]:
        if each.accuracy is not None:
            found = accuracies(each.profile, EPISODES)
            assert found == pytest.approx((each.proximity_accuracy, each.contact_accuracy), abs=1e-12)


def test_chosen_candidate_has_the_best_accuracy_and_then_the_widest_margin():
    fitted = fit_profile(BASE, EPISODES, SMALL)
    valid = [each for each in fitted.candidates if each.accuracy is not None]
    assert fitted.best.accuracy == max(each.accuracy for each in valid)
    tied = [each for each in valid if each.accuracy == fitted.best.accuracy]
    assert tied[0].proximity_margin < fitted.best.proximity_margin
    rivals = [each for each in tied if each.proximity_margin == fitted.best.proximity_margin]
    assert rivals[0].contact_margin < fitted.best.contact_margin
    assert fitted.best.contact_margin == max(each.contact_margin for each in rivals)


def test_candidates_without_a_grid_are_reported_without_a_number():
    fitted = fit_profile(BASE, EPISODES, SMALL)
    hidden = [each for each in fitted.candidates if each.profile.tau_b == 5 and each.profile.polarity == "dark"]
    assert hidden
    assert all(each.accuracy is None and each.contact_margin is None for each in hidden)


def test_fit_is_the_same_every_time():
    assert fit_profile(BASE, EPISODES, SMALL) == fit_profile(BASE, EPISODES, SMALL)


def test_value_that_is_given_twice_counts_once():
    twice = Candidates(tau_b=(35, 35), similarity=("iou", "iou"), difference_blur_px=(0,))
    once = Candidates(tau_b=(35,), similarity=("iou",), difference_blur_px=(0,))
    assert fit_profile(BASE, EPISODES, twice).profile == fit_profile(BASE, EPISODES, once).profile


def test_what_is_not_fitted_stays():
    base = dataclasses.replace(BASE, entropy_width=0.125, background_count=2)
    fitted = fit_profile(base, EPISODES, SMALL).profile
    assert (fitted.entropy_width, fitted.background_count, fitted.reference_count) == (0.125, 2, 4)


def test_missing_class_is_named():
    episode = EPISODES[0]
    dark = dataclasses.replace(
        episode, classes=[None if each is FrameClass.LIGHT else each for each in episode.classes]
    )
    with pytest.raises(ConfigError, match="class Light"):
        fit_profile(BASE, [dark], SMALL)


def test_no_candidate_with_a_grid_is_an_error():
    with pytest.raises(ConfigError, match="none of 3 candidates"):
        fit_profile(
            BASE,
            EPISODES,
            Candidates(tau_b=(0,), polarity=("dark",), grid_blur_px=(0,), difference_blur_px=(0,)),
        )


def test_probabilities_are_sure_at_the_end_of_the_range_of_a_threshold_near_one():
    fitted = sharpen(dataclasses.replace(load_profile("published"), tau_c=0.94, tau_g=0.991))
    assert 1 / (1 + math.exp((1 - fitted.tau_g) / fitted.similarity_width)) == pytest.approx(0.047, abs=0.001)
    assert 1 / (1 + math.exp((fitted.tau_c - 1) / fitted.correlation_width)) == pytest.approx(0.953, abs=0.001)


def test_probabilities_keep_their_widths_where_thresholds_leave_room():
    published = load_profile("published")
    assert sharpen(published) == published


@pytest.mark.parametrize(
    ("similarity", "expected"),
    [([0.99, 0.9, 0.98, 0.91], 1.0), ([0.99, 0.9, 0.8, 0.7], 0.5)],
)
def test_held_out_accuracy_asks_for_one_threshold_that_serves_all_episodes(similarity, expected):
    """Each episode alone is told apart in both cases; in the second no threshold of one serves the other."""
    classes = [FrameClass.CLEAR, FrameClass.CONTACT] * 2
    owner = np.array([0, 0, 1, 1])
    at_rest = [np.array([True, False, False, False]), np.array([False, False, True, False])]
    noise = np.zeros(4, bool)
    assert held_out_accuracy(np.array(similarity), noise, classes, owner, at_rest, 4.0) == expected
    assert held_out_accuracy(np.array(similarity[:2]), noise[:2], classes[:2], owner[:2], [at_rest[0][:2]], 4.0) is None
