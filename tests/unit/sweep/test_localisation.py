import numpy as np
import pytest

from magicsim.sweep.parts import change_centroids, left_out_predictions


def test_centroid_of_a_change_is_where_it_is():
    reference = np.full((40, 30, 3), 90.0)
    frame = reference.copy()
    frame[30, 6, 0] += 20
    frame[10, 15, 2] -= 20
    found = change_centroids(frame, reference)
    assert found[[0, 3]] == pytest.approx([6.5 / 30 - 0.5, 30.5 / 40 - 0.5])
    assert found[[2, 5]] == pytest.approx([15.5 / 30 - 0.5, 10.5 / 40 - 0.5])
    assert found[[1, 4]] == pytest.approx([0, 0])


def test_regression_finds_a_linear_law_in_rows_that_it_has_not_seen():
    random = np.random.default_rng(0)
    features, law = random.normal(size=(14, 6)), random.normal(size=(6, 2))
    targets = features @ law + 3.0
    assert left_out_predictions(features, targets) == pytest.approx(targets, abs=0.02)


def test_regression_of_noise_is_no_better_than_the_mean_of_the_others():
    random = np.random.default_rng(1)
    targets = random.normal(size=(40, 2))
    error = left_out_predictions(random.normal(size=(40, 6)), targets) - targets
    assert np.sqrt((error**2).mean()) > 0.9 * targets.std()
