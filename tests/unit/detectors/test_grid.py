import cv2
import numpy as np
import pytest

from magicsim.detectors.fusion import blur, grid_mask, levelled

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


def stripes(bright=120, dark=60):
    """Rows of two levels, three of each after the other, under light that falls off to the right."""
    rows = np.where(np.arange(60) // 3 % 2 == 0, bright, dark)[:, None] * np.linspace(1, 0.5, 80)
    return np.repeat(rows[:, :, None], 3, 2).astype(np.uint8)


def test_levelled_stripes_are_what_they_are_wherever_the_light_is_weak():
    mask = grid_mask(levelled(stripes(), 6), tau_b=100, polarity="bright")
    assert (mask == mask[:, :1]).all()
    assert (mask[10:50, 0, 0] > 0).mean() == 0.5
    plain = grid_mask(stripes(), tau_b=70, polarity="bright")
    assert not (plain == plain[:, :1]).all()


def test_levels_do_not_change_with_the_brightness_of_all():
    bright, dim = (levelled(stripes(2 * level, level), 6).astype(int) for level in (100, 50))
    assert np.abs(bright - dim).max() <= 3  # a level of 25 is rounded to 2 %


@pytest.mark.parametrize(("level", "expected"), [(0, 0), (1, 100), (200, 100)])
def test_an_even_image_is_as_bright_as_its_surroundings(level, expected):
    assert (levelled(np.full((20, 20, 3), level, np.uint8), 4) == expected).all()


def test_without_surroundings_an_image_stays():
    image = stripes()
    assert levelled(image, 0) is image


@pytest.mark.parametrize("surround_px", [2, 4, 6, 9])
def test_surroundings_are_the_gaussian_mean_over_all_pixels(surround_px):
    rows, columns = np.indices((160, 120))
    light = np.exp(-((rows - 50) ** 2 + (columns - 45) ** 2) / 1e4)
    walls = np.where((rows % 23 < 2) | (columns % 23 < 2), 0.6, 1.0)
    image = np.repeat((240 * walls * light)[..., None], 3, axis=2).astype(np.uint8)
    mean = cv2.GaussianBlur(image.astype(float), (0, 0), surround_px)
    inner = np.s_[2 * surround_px : -2 * surround_px, 2 * surround_px : -2 * surround_px]
    expected = 100.0 * image[inner] / mean[inner]
    assert np.abs(levelled(image, surround_px)[inner] - expected).max() < 0.5 + 0.01 * expected.max()
