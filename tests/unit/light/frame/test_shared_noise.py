"""The share of the untouched sensor's noise: all of it where nothing changed, none where the noise is another."""

import numpy as np
import pytest

from magicsim.light.frame.anchored_image import change_without_shared_noise

SHAPE = (60, 50, 3)
RNG_SEED = 7
SIGMA = 0.1


def noise(rng):
    return rng.normal(scale=SIGMA, size=SHAPE)


def images(*arrays):
    return [array.astype(np.float32) for array in arrays]


@pytest.fixture
def rng():
    return np.random.default_rng(RNG_SEED)


def test_untouched_frame_has_no_change(rng):
    careful = 1 + 0.3 * rng.random(SHAPE)
    cheap = careful + noise(rng)
    change = change_without_shared_noise(*images(cheap, cheap, careful))
    np.testing.assert_allclose(change, 0, atol=1e-6)


def test_frame_without_noise_in_the_untouched_images_stays(rng):
    now, careful = images(1 + rng.random(SHAPE), 1 + rng.random(SHAPE))
    change = change_without_shared_noise(now, careful, careful)
    np.testing.assert_array_equal(change, now.astype(np.float64) - careful)


def test_foreign_noise_grows_by_less_than_a_hundredth(rng):
    # A plain control variate doubles its variance.
    careful, own = np.ones(SHAPE), noise(rng)
    change = change_without_shared_noise(*images(careful + own, careful + noise(rng), careful))
    assert np.var(change) < 1.01 * np.var(own)


@pytest.mark.parametrize("correlation", [0.5, 0.8])
def test_shared_part_is_taken_off(rng, correlation):
    careful, shared = np.ones(SHAPE), noise(rng)
    now = careful + correlation * shared + np.sqrt(1 - correlation**2) * noise(rng)
    change = change_without_shared_noise(*images(now, careful + shared, careful))
    assert np.var(change) == pytest.approx((1 - correlation**2) * np.var(shared), rel=0.03)


def test_dimmed_frame_with_all_of_the_noise_keeps_none(rng):
    careful = np.ones(SHAPE)
    cheap = careful + noise(rng)
    change = change_without_shared_noise(*images(0.2 * cheap, cheap, careful))
    np.testing.assert_allclose(change, -0.8, atol=1e-6)


def test_a_change_far_greater_than_the_noise_keeps_its_mean(rng):
    careful, change = np.ones(SHAPE), np.zeros(SHAPE)
    change[25:35, 20:30] = 2.0
    found = []
    for _ in range(400):
        shared = noise(rng)
        found.append(change_without_shared_noise(*images(careful + change + shared, careful + shared, careful)))
    error = np.std(found, axis=0).mean() / np.sqrt(400)
    mean = np.mean(found, axis=0) - change
    for block in (mean[25:35, 20:30], mean[:2], mean[:, -2:], mean[:3, :3]):
        assert abs(block.mean()) < 4 * error / np.sqrt(block.size / 3)
