"""The adaptive Wiener filter against what it must do to noise alone, to detail alone, and to both."""

import numpy as np
import pytest

from magicsim.light.frame.wiener import REACH_PX, detail, filtered

SHAPE = (90, 80, 3)
RNG_SEED = 11
SIGMA = 0.1
VARIANCE = np.full(SHAPE, SIGMA**2)


def noise():
    return np.random.default_rng(RNG_SEED).normal(scale=SIGMA, size=SHAPE)


def stripes(amplitude):
    """Detail of two pixels' period, whose local mean is next to nothing."""
    return amplitude * np.resize([1.0, -1.0], SHAPE[1])[None, :, None] * np.ones(SHAPE)


def test_image_without_noise_stays():
    image = noise()
    np.testing.assert_allclose(filtered(image, np.zeros_like(VARIANCE)), image, atol=1e-12)


def test_even_image_stays_even():
    np.testing.assert_allclose(filtered(np.full(SHAPE, 0.7), VARIANCE), 0.7, rtol=1e-12)


def test_of_noise_alone_little_more_than_its_local_mean_is_left():
    image = noise()
    kept = filtered(image, VARIANCE) - (image - detail(image))
    assert np.var(kept) < 0.03 * SIGMA**2


def test_detail_ten_times_stronger_than_noise_is_kept():
    signal = stripes(10 * SIGMA)
    found = filtered(signal + noise(), VARIANCE)
    assert np.mean(found * signal) / np.mean(signal**2) == pytest.approx(1, abs=0.02)


def test_detail_as_strong_as_noise_is_off_by_less_than_kept_or_dropped():
    # Either of them is off by the noise's variance; weights from exact energies, 1/2 and then 1/3, by 5/9 of it.
    signal = stripes(SIGMA)
    error = filtered(signal + noise(), VARIANCE) - signal
    assert 5 / 9 * SIGMA**2 < np.mean(error**2) < 0.7 * SIGMA**2


def test_detail_in_one_channel_speaks_for_all():
    signal = stripes(10 * SIGMA)
    signal[:, :, 1:] *= 0.1
    found = filtered(signal + noise(), VARIANCE)
    faint = signal[:, :, 2]
    assert np.mean(found[:, :, 2] * faint) / np.mean(faint**2) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("ratio", [1, 10])
def test_detail_in_a_quiet_channel_is_not_lost_in_the_noise_of_another(ratio):
    sigmas = SIGMA * np.array([ratio, 1, 1])
    signal = stripes(5 * SIGMA) * [0, 0, 1]
    found = filtered(signal + noise() * [ratio, 1, 1], sigmas**2 * np.ones(SHAPE))
    assert np.mean(found * signal) / np.mean(signal**2) == pytest.approx(0.89, abs=0.03)


def test_channel_without_noise_stays():
    image, variance = noise(), VARIANCE * [1, 0, 1]
    found = filtered(image, variance)
    np.testing.assert_array_equal(found[:, :, 1], image[:, :, 1])
    assert np.var(detail(found)[:, :, 0]) < 0.1 * SIGMA**2


@pytest.mark.parametrize("skewed", [False, True])
def test_means_of_blocks_stay_around_an_edge(skewed):
    edge = np.zeros(SHAPE)
    edge[:, 45:] = 3 * SIGMA
    own = np.random.default_rng(RNG_SEED).exponential(SIGMA, SHAPE) if skewed else noise()
    image = edge + own
    change = (filtered(image, VARIANCE) - image).reshape(9, 10, 8, 10, 3).mean((1, 3))
    # A block of 10 x 10 pixels is itself no better known than this.
    assert np.abs(change).max() < SIGMA / 10 * (2 if skewed else 1)
    assert abs(change.mean()) < 0.01 * SIGMA


def test_scale_does_not_matter():
    image = noise()
    np.testing.assert_allclose(filtered(50 * image, 2500 * VARIANCE), 50 * filtered(image, VARIANCE), rtol=1e-9)


def test_crop_with_its_margin_is_the_crop_of_the_whole():
    image = noise()
    inner = filtered(image[5:, 8:], VARIANCE[5:, 8:])[REACH_PX:, REACH_PX:]
    np.testing.assert_array_equal(inner, filtered(image, VARIANCE)[5 + REACH_PX :, 8 + REACH_PX :])
