import numpy as np
import pytest

from magicsim.light.transport.cached_light import cell_slopes

COUNTS = (4, 5, 3)


def centres(counts=COUNTS):
    """Of a sheared and stretched grid, x fastest, shape (cells, 3)."""
    z, y, x = (axis.ravel() for axis in np.indices(counts[::-1]))
    grid = np.stack([x, y, z], 1) * [1.0, 1.1, 0.9]
    return grid @ np.array([[1, 0.2, 0], [0, 1, 0.1], [0.3, 0, 1]]).T


def test_linear_field_has_its_slopes_in_every_cell_of_a_deformed_grid():
    truth = np.array([[1.0, 0, 2], [0.5, -1, 0], [0, 3, 1]])
    found = cell_slopes(centres() @ truth, centres(), COUNTS)
    np.testing.assert_allclose(found, np.broadcast_to(truth, found.shape), atol=1e-12)


def test_axis_with_a_single_cell_has_no_slope():
    flat = (4, 5, 1)
    place = centres(flat) * [1, 1, 0]
    found = cell_slopes(place @ np.ones((3, 3)), place, flat)
    np.testing.assert_allclose(found[:, 2], 0, atol=1e-12)
    np.testing.assert_allclose(found[:, :2], 1, atol=1e-12)


def test_single_cell_has_no_slopes():
    assert not cell_slopes(np.ones((1, 3)), np.zeros((1, 3)), (1, 1, 1)).any()


def test_curved_field_is_met_in_second_order():
    errors = []
    for refinement in (1, 2):
        counts = (8 * refinement, 2, 2)
        place = centres(counts) / refinement
        exact = np.cos(0.3 * place[:, 0])
        found = cell_slopes(np.repeat(np.sin(0.3 * place[:, :1]) / 0.3, 3, 1), place, counts)[:, 0, 0]
        inner = np.tile(np.arange(counts[0]), 4)
        errors.append(np.abs(found - exact)[(inner > 0) & (inner < counts[0] - 1)].max())
    assert errors[1] < 0.3 * errors[0]
    assert errors[0] > 1e-4


@pytest.mark.parametrize("channel", range(3))
def test_channels_do_not_mix(channel):
    field = np.zeros((len(centres()), 3))
    field[:, channel] = centres()[:, 0]
    found = cell_slopes(field, centres(), COUNTS)
    assert not np.delete(found, channel, axis=2).any()
    assert found[:, 0, channel] == pytest.approx(1)
