import numpy as np
import pytest

from magicsim_experiments.learn.baselines import mean_score


def test_interval_holds_the_mean_of_other_presses_as_often_as_it_says():
    random = np.random.default_rng(1)
    press = np.repeat(np.arange(40), 4)
    held = 0
    for _ in range(200):
        values = 2 + np.repeat(random.normal(size=40), 4)  # frames of a press are all alike
        found = mean_score(values, press)
        held += found.low <= 2 <= found.high
    assert 0.88 < held / 200 <= 0.99  # frames as if independent would hold it in 67 % of the cases


def test_values_that_do_not_exist_are_left_out():
    found = mean_score(np.array([1.0, np.nan, 3.0]), np.array([0, 0, 1]))
    assert (found.value, found.frames, found.presses) == (2.0, 2, 2)
    assert np.isnan(mean_score(np.array([np.nan]), np.array([0])).value)
    assert mean_score(np.array([5.0]), np.array([0])).low == pytest.approx(5.0)
