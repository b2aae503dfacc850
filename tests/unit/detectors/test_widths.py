import dataclasses
import math

import numpy as np
import pytest

from magicsim.detectors import DetectorProfile, FrameClass, detect_all, fuse
from magicsim.detectors.thresholds import NARROWEST, fit_widths, logistic_width
from magicsim.errors import ConfigError

from .test_calibrate import BASE, EPISODES

PROFILE = dataclasses.replace(BASE, tau_e=1.0, tau_c=0.95, tau_g=0.6, grid_blur_px=0)


@pytest.mark.parametrize("width", [0.02, 0.3, 2.0])
def test_width_behind_logistic_labels_is_found(width):
    """Distances of both signs alike, each positive with the probability that the width says."""
    rng = np.random.default_rng(1)
    distances = rng.uniform(-4 * width, 4 * width, 40_000)
    positive = rng.random(distances.size) < 1 / (1 + np.exp(-distances / width))
    assert logistic_width(distances[positive], distances[~positive], widest=8.0) == pytest.approx(width, rel=0.03)


def test_separable_groups_get_the_width_of_their_smoothed_targets():
    """With n frames at +1 and n at -1 the logistic at 1 / w is (n + 1) / (n + 2)."""
    for count in (1, 8, 50):
        ones = np.ones(count)
        assert logistic_width(ones, -ones, widest=8.0) == pytest.approx(1 / math.log(count + 1), rel=1e-9)


def test_group_sizes_do_not_shift_the_width():
    near, far = np.array([1.0]), np.array([-1.0])
    one = logistic_width(np.repeat(near, 400), np.repeat(far, 400), widest=8.0)
    many = logistic_width(np.repeat(near, 400), np.repeat(far, 4000), widest=8.0)
    assert one > many > 1 / math.log(4001)


def test_distances_that_speak_against_their_classes_get_the_widest():
    assert logistic_width([-1.0], [1.0], widest=2.0) == 2.0
    assert logistic_width([0.0], [0.0], widest=2.0) == 2.0
    assert logistic_width([1e-9], [-1e-9], widest=2.0) == NARROWEST


def test_fitted_widths_keep_thresholds_and_verdicts():
    fitted = fit_widths(PROFILE, EPISODES)
    names = ("entropy_width", "correlation_width", "similarity_width")
    assert all(getattr(fitted, name) != getattr(PROFILE, name) for name in names)
    assert dataclasses.replace(fitted, **{name: getattr(PROFILE, name) for name in names}) == PROFILE
    for episode in EPISODES:
        references = fuse(episode.references, PROFILE)
        before, after = (detect_all(episode.frames, references, each) for each in (PROFILE, fitted))
        assert [each.combined for each in before] == [each.combined for each in after]


def log_loss(profile):
    """Mean cross-entropy of p_touch over frames that are not Noise, both classes weighing the same."""
    losses = {True: [], False: []}
    for episode in EPISODES:
        for verdict, each in zip(
            detect_all(episode.frames, fuse(episode.references, profile), profile), episode.classes, strict=True
        ):
            if verdict.proximity != "Noise":
                touched = each is FrameClass.CONTACT
                losses[touched].append(-math.log(verdict.p_touch if touched else 1 - verdict.p_touch))
    return np.mean(losses[True]) + np.mean(losses[False])


def test_fitted_width_is_more_likely_than_a_wide_one():
    assert log_loss(fit_widths(PROFILE, EPISODES)) < log_loss(dataclasses.replace(PROFILE, similarity_width=0.3))


def test_every_class_and_a_grid_are_needed():
    with pytest.raises(ConfigError, match="class Clear, Near, Contact, Light"):
        fit_widths(PROFILE, [])
    with pytest.raises(ConfigError, match="no grid with tau_b = 0"):
        fit_widths(DetectorProfile(tau_b=0, reference_count=4), EPISODES)
