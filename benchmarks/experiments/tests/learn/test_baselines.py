import numpy as np
import pytest

from magicsim_experiments.learn.baselines import (
    change_features,
    constant_answers,
    lean_features,
    linear_answers,
    neighbour_answers,
)

from .made import made_samples


def test_constant_is_the_median_and_the_more_frequent_value():
    samples = made_samples()
    found = constant_answers(samples, 2)
    assert found[0, 0] == pytest.approx(np.nanmedian(samples.targets[:, 0]))
    assert found[1, 1] == 1.0
    assert found[0, 2] in samples.labels[2].choices


def test_nearest_neighbour_of_a_known_frame_is_itself():
    samples = made_samples()
    found = neighbour_answers(samples, samples, "difference")
    there = np.isfinite(samples.targets)
    np.testing.assert_array_equal(found[there], samples.targets[there])
    assert np.isfinite(found).all()


def test_linear_fit_recovers_a_line_and_answers_flags_and_choices_by_their_values():
    samples = made_samples()
    there = np.isfinite(samples.targets[:, 0])
    x = np.where(there, samples.targets[:, 0], 0.0)
    features = np.column_stack([2 * x + 1, samples.targets[:, 1]])
    exact = type(samples)(**{name: getattr(samples, name) for name in samples.__slots__} | {"features": features})
    found = linear_answers(exact, exact)
    np.testing.assert_allclose(found[there, 0], x[there], atol=0.01)
    assert set(found[:, 1]) <= {0.0, 1.0}
    assert set(found[:, 2]) <= set(samples.labels[2].choices)


def test_change_features_are_centroid_and_spread_of_a_spot():
    image = np.zeros((1, 11, 21, 3), np.float32)
    image[0, 2, 15] = 9.0
    found = change_features(image, np.zeros((11, 21, 3)))[0]
    np.testing.assert_allclose(found[:3], 15.5 / 21 - 0.5)
    np.testing.assert_allclose(found[6:9], 2.5 / 11 - 0.5)
    np.testing.assert_allclose(found[[3, 4, 5, 9, 10, 11]], 0, atol=1e-7)


@pytest.mark.parametrize("angle_deg", [-60.0, -30.0, 0.0, 20.0, 45.0, 90.0])
def test_lean_features_tell_the_angle_of_a_bar_wherever_it_lies(angle_deg: float):
    rows, columns = np.mgrid[:120, :100] - np.array([70.0, 45.0])[:, None, None]
    turn = np.radians(angle_deg)
    along, across = rows * np.cos(turn) + columns * np.sin(turn), columns * np.cos(turn) - rows * np.sin(turn)
    image = np.where((np.abs(along) < 25.3) & (np.abs(across) < 4.3), 9.0, 0.0)[None, ..., None].repeat(3, 3)
    found = lean_features(image.astype(np.float32), np.zeros((120, 100, 3), np.float32))[0]
    missed = np.degrees(np.arctan2(found[3:], found[:3])) / 2 - angle_deg
    np.testing.assert_allclose((missed + 90) % 180 - 90, 0, atol=0.5)
    assert (np.hypot(found[:3], found[3:]) > 0.9).all()


def test_round_change_leans_nowhere():
    rows, columns = np.mgrid[:60, :60] - 29.5
    image = np.where(rows**2 + columns**2 < 200, 9.0, 0.0)[None, ..., None].repeat(3, 3)
    np.testing.assert_allclose(lean_features(image, np.zeros((60, 60, 3))), 0, atol=1e-9)
