import numpy as np
import pytest
from laboratory.operating_point.draws import first_points, next_point


def test_longer_search_begins_with_the_same_points():
    few, many = first_points(5, 3, seed=2), first_points(32, 3, seed=2)
    assert (few == many[:5]).all()
    assert many.mean(0) == pytest.approx(0.5, abs=0.02)


def test_later_points_stay_near_the_good_ones_and_inside_the_cube():
    good = [np.array([0.02, 0.5]), np.array([0.04, 0.52])]
    drawn = np.array([next_point(good, seed=0, index=index) for index in range(500)])
    assert drawn.min() >= 0
    assert drawn.max() <= 1
    assert drawn.mean(0) == pytest.approx([0.04, 0.51], abs=0.02)
    assert (next_point(good, seed=0, index=3) == drawn[3]).all()
