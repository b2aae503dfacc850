import numpy as np
import pytest

from magicsim.detectors.grid import blur, grid_mask

LEVELS = np.array([0, 35, 36, 255], dtype=np.uint8).reshape(1, 4, 1).repeat(3, axis=2)


@pytest.mark.parametrize(("polarity", "expected"), [("dark", [255, 255, 0, 0]), ("bright", [0, 0, 255, 255])])
def test_level_equal_to_tau_b_counts_as_dark(polarity, expected):
    assert grid_mask(LEVELS, tau_b=35, polarity=polarity)[0, :, 0].tolist() == expected


@pytest.mark.parametrize("size", [0, 1])
def test_blur_of_no_size_changes_nothing(size):
    assert np.array_equal(blur(LEVELS, size), LEVELS)


def test_blur_keeps_channels_apart_and_spreads_a_point():
    image = np.zeros((9, 9, 3), dtype=np.uint8)
    image[4, 4, 1] = 255
    blurred = blur(image, 5)
    assert blurred[..., [0, 2]].max() == 0
    assert 0 < blurred[4, 5, 1] < blurred[4, 4, 1] < 255
    assert blurred[4, 7, 1] == 0
