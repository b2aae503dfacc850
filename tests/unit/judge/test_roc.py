import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.errors import ConfigError
from magicsim.judge.curves import rates_at, roc_curve


def test_curve_by_hand():
    curve = roc_curve([3, 2, 2, 1, 0], [True, True, False, True, False])
    assert curve.thresholds.tolist() == [np.inf, 3, 2, 1, 0]
    assert curve.hit_rate == pytest.approx([0, 1 / 3, 2 / 3, 1, 1])
    assert curve.false_alarm_rate == pytest.approx([0, 0, 1 / 2, 1 / 2, 1])
    assert curve.area == pytest.approx((1 + 1 + 0.5 + 1 + 0 + 1) / 6)


@given(
    positive=st.lists(st.integers(-5, 5), min_size=1, max_size=15),
    negative=st.lists(st.integers(-5, 5), min_size=1, max_size=15),
)
def test_area_is_the_share_of_pairs_in_the_right_order(positive, negative):
    pairs = [(one > other) + (one == other) / 2 for one in positive for other in negative]
    labels = [True] * len(positive) + [False] * len(negative)
    assert roc_curve(positive + negative, labels).area == pytest.approx(np.mean(pairs), abs=1e-12)


@pytest.mark.parametrize(
    ("threshold", "expected"), [(3.5, (0, 0)), (3, (0.5, 0)), (2.5, (0.5, 0)), (2, (0.5, 1)), (0, (1, 1))]
)
def test_score_at_the_threshold_counts_as_positive(threshold, expected):
    assert rates_at([3, 1, 2], [True, True, False], threshold) == expected


@pytest.mark.parametrize(
    ("scores", "labels"), [([1.0, 2.0], [True, True]), ([1.0], [False]), ([1.0, np.nan], [True, False])]
)
def test_one_group_alone_or_a_score_that_is_no_number_is_refused(scores, labels):
    with pytest.raises(ConfigError, match="must be some, not all, with finite scores"):
        roc_curve(scores, labels)
