import numpy as np
import pytest

from magicsim.learn.baselines import change_features, constant_answers, linear_answers, neighbour_answers

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
