import numpy as np
import pytest

from magicsim.sampling.points import unit_points


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_points_do_not_depend_on_how_many_there_are(sampling: str):
    many = unit_points(70, 5, seed=3, stream=1, sampling=sampling)
    np.testing.assert_array_equal(unit_points(9, 5, seed=3, stream=1, sampling=sampling), many[:9])
    assert ((many >= 0) & (many < 1)).all()


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_seed_and_stream_give_other_points(sampling: str):
    points = [
        unit_points(8, 4, seed=seed, stream=stream, sampling=sampling) for seed, stream in ((1, 1), (2, 1), (1, 2))
    ]
    assert not np.allclose(points[0], points[1])
    assert not np.allclose(points[0], points[2])


def test_quasi_random_points_fill_every_dimension_evenly():
    points = unit_points(64, 20, seed=1, stream=2, sampling="sobol")
    for dimension in points.T:
        np.testing.assert_array_equal(np.histogram(dimension, bins=64, range=(0, 1))[0], 1)


def test_nothing_to_draw_is_no_dimension():
    assert unit_points(3, 0, seed=1, stream=1, sampling="sobol").shape == (3, 0)
