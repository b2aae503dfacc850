import numpy as np
import pytest

from magicsim.arrays import Array
from magicsim.sampling.distribution import RUN, unit_points


@pytest.mark.parametrize("sampling", ["sobol", "stratified", "random"])
def test_points_do_not_depend_on_how_many_there_are(sampling: str):
    many = unit_points(70, 5, seed=3, stream=1, sampling=sampling)
    np.testing.assert_array_equal(unit_points(9, 5, seed=3, stream=1, sampling=sampling), many[:9])
    assert ((many >= 0) & (many < 1)).all()


@pytest.mark.parametrize("sampling", ["sobol", "stratified", "random"])
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


def test_every_run_of_stratified_points_has_one_in_each_part_of_every_dimension():
    points = unit_points(3 * RUN, 20, seed=1, stream=2, sampling="stratified")
    for run in np.split(points, 3):
        for dimension in run.T:
            np.testing.assert_array_equal(np.histogram(dimension, bins=RUN, range=(0, 1))[0], 1)


def told_by_another(points: Array) -> float:
    """Largest share of pairs of points in which the halves of one dimension and of another agree, or do not."""
    signs = np.where(points < 0.5, -1.0, 1.0)
    agreement = np.abs(signs.T @ signs) / len(signs)
    return float((1 + agreement[~np.eye(len(agreement), dtype=bool)].max()) / 2)


def test_dimensions_of_few_points_are_not_tied_to_each_other():
    """Of few Sobol points a choice would tell a place: no dataset may have that."""
    seeds = range(10)
    stratified, sobol = (
        np.mean([told_by_another(unit_points(32, 12, seed=seed, stream=2, sampling=sampling)) for seed in seeds])
        for sampling in ("stratified", "sobol")
    )
    assert stratified < 0.8
    assert sobol > 0.99


def test_nothing_to_draw_is_no_dimension():
    assert unit_points(3, 0, seed=1, stream=1, sampling="sobol").shape == (3, 0)
