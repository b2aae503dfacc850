"""Displacements below a bound are left out: none is off by more than the bound, and strains hardly change."""

import numpy as np
import pytest

from magicsim.simulation.meshes import FADE, still

BOUND_MM = 0.005


@pytest.fixture
def ways_mm():
    return np.linspace(0, 3 * FADE * BOUND_MM, 2001)


def moved(ways_mm):
    rest = np.random.default_rng(1).normal(size=(len(ways_mm), 3))
    direction = rest / np.linalg.norm(rest, axis=1, keepdims=True)
    found = still(rest + ways_mm[:, None] * direction, rest, BOUND_MM)
    return np.einsum("vi,vi->v", found - rest, direction), np.linalg.norm(found - rest, axis=1)


def test_no_vertex_is_off_by_more_than_the_bound_and_all_move_their_own_way(ways_mm):
    along, length = moved(ways_mm)
    assert np.abs(along - length).max() < 1e-12
    assert np.abs(along - ways_mm).max() <= BOUND_MM + 1e-12


def test_small_displacements_are_none_and_large_ones_exact(ways_mm):
    along, _ = moved(ways_mm)
    assert not along[ways_mm <= BOUND_MM].any()
    np.testing.assert_allclose(along[ways_mm >= FADE * BOUND_MM], ways_mm[ways_mm >= FADE * BOUND_MM], atol=1e-12)


def test_strains_grow_by_a_quarter_at_most_and_nothing_folds(ways_mm):
    along, _ = moved(ways_mm)
    slope = np.diff(along) / np.diff(ways_mm)
    assert slope.min() > -1e-9
    assert slope.max() < 1.25


def test_bound_of_zero_leaves_out_nothing():
    rest, vertices = np.zeros((2, 3)), np.array([[1e-6, 0, 0], [0, 1, 0]])
    assert still(vertices, rest, 0.0) is vertices
