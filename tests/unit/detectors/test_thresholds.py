import numpy as np
import pytest

from magicsim.detectors import FrameClass
from magicsim.detectors.thresholds import (
    candidate_cuts,
    fit_contact,
    fit_proximity,
    rest_limit,
    share_below,
    share_from,
    within_spread,
)

CLEAR, NEAR, CONTACT, LIGHT = FrameClass


def test_cuts_are_the_middles_between_values_and_ends():
    cuts, gaps = candidate_cuts(np.array([0.2, 0.6, 0.2]), (0.0, 1.0))
    assert cuts == pytest.approx([0.1, 0.4, 0.8])
    assert gaps == pytest.approx([0.1, 0.2, 0.2])


def test_spread_is_within_the_groups_not_between_them():
    values = np.array([0.0, 2.0, 100.0, 102.0])
    groups = [values < 50, values > 50, values > 500]
    assert within_spread(values, groups) == pytest.approx(1.0)


def test_separable_proximity_gets_the_middles_of_the_gaps():
    classes = [CLEAR, CLEAR, NEAR, NEAR, CONTACT, LIGHT, LIGHT]
    entropy = np.array([0.1, 0.5, 1.5, 2.0, 0.2, 6.0, 6.5])
    correlation = np.array([0.9, 0.0, 0.1, 0.3, 0.5, 0.9, 0.95])
    fit = fit_proximity(entropy, correlation, classes)
    assert fit.accuracy == 1.0
    assert fit.tau_e == pytest.approx(1.0)
    assert fit.tau_c == pytest.approx(0.6)  # the quiet Contact frame's correlation does not matter


def test_contact_frames_are_kept_out_of_noise():
    classes = [CLEAR, NEAR, CONTACT, CONTACT, LIGHT]
    entropy = np.array([0.1, 2.0, 3.0, 3.0, 6.0])
    correlation = np.array([0.0, 0.1, 0.5, 0.7, 0.9])
    assert fit_proximity(entropy, correlation, classes).tau_c == pytest.approx(0.8)


def test_contact_recall_weighs_more_than_the_recall_of_light():
    # No tau_c is right for both; Contact counts for a half of its accuracy, Light for a third.
    classes = [CLEAR, NEAR, CONTACT, LIGHT]
    entropy = np.array([0.1, 6.0, 6.0, 6.0])
    correlation = np.array([0.0, 0.1, 0.9, 0.5])
    fit = fit_proximity(entropy, correlation, classes)
    assert fit.tau_c == pytest.approx(0.95)
    assert fit.accuracy == pytest.approx(2 / 3)


def test_overlapping_classes_get_the_best_compromise():
    classes = [*[CONTACT] * 4, *[NEAR] * 4]
    similarity = np.array([0.1, 0.2, 0.3, 0.7, 0.6, 0.8, 0.9, 0.95])
    fit = fit_contact(similarity, np.zeros(8, dtype=bool), classes)
    assert fit.tau_g == pytest.approx(0.45)
    assert fit.accuracy == pytest.approx((0.75 + 1.0) / 2)


def test_noise_frames_are_untouched_whatever_their_similarity():
    classes = [CONTACT, CONTACT, CLEAR, LIGHT]
    similarity = np.array([0.1, 0.4, 0.9, 0.6])
    noise = np.array([False, True, False, True])
    fit = fit_contact(similarity, noise, classes)
    assert fit.tau_g == pytest.approx(0.5)
    assert fit.accuracy == pytest.approx((0.5 + 1.0) / 2)


def test_all_contact_frames_in_noise_still_give_a_threshold():
    fit = fit_contact(np.array([0.1, 0.9]), np.array([True, False]), [CONTACT, CLEAR])
    assert 0.0 < fit.tau_g < 0.9
    assert fit.accuracy == pytest.approx(0.5)


def test_value_at_a_cut_is_not_below_it():
    values, cuts = np.array([1.0, 2.0, 2.0, 3.0]), np.array([2.0, 2.5])
    assert share_below(values, cuts, 4).tolist() == [0.25, 0.75]
    assert share_from(values, cuts, 4).tolist() == [0.75, 0.25]


def test_thresholds_keep_their_distance_from_the_noisiest_sensor_at_rest():
    quiet, noisy = np.array([0.30, 0.31, 0.29, 0.30]), np.array([0.5, 0.6, 0.4, 0.5])
    values = np.concatenate([quiet, noisy, [0.62, 2.0, 2.1]])
    first, second = np.arange(11) < 4, (np.arange(11) >= 4) & (np.arange(11) < 8)
    limit = rest_limit(values, [first, second], 4.0)
    assert limit == pytest.approx(0.5 + 4 * np.std(noisy, ddof=1))
    assert rest_limit(values, [np.arange(11) == 0], 4.0) == -np.inf
    classes = [FrameClass.CLEAR] * 8 + [FrameClass.NEAR, FrameClass.CONTACT, FrameClass.LIGHT]
    correlation = np.array([0.0] * 10 + [0.9])
    assert fit_proximity(values, correlation, classes).tau_e < limit
    assert fit_proximity(values, correlation, classes, least_tau_e=limit).tau_e >= limit


@pytest.mark.parametrize(("most", "expected"), [(0.2, 0.2), (-3.0, 0.0)])
def test_a_limit_before_all_candidates_is_the_threshold(most, expected):
    similarity = np.array([0.99, 0.98, 0.5, 0.4])
    classes = [FrameClass.CLEAR, FrameClass.CLEAR, FrameClass.CONTACT, FrameClass.CONTACT]
    fit = fit_contact(similarity, np.zeros(4, bool), classes, most_tau_g=most)
    assert fit.tau_g == pytest.approx(expected, abs=1e-9)
