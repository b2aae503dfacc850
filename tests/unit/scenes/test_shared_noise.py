"""The share of the untouched sensor's noise: all of it where nothing changed, none where the noise is another."""

import numpy as np
import pytest

from magicsim.scenes.shared_noise import REACH_PX, without_shared_noise

SHAPE = (60, 50, 3)
RNG_SEED = 7


def noise(rng):
    return rng.normal(scale=0.1, size=SHAPE)


def images(*arrays):
    return [array.astype(np.float32) for array in arrays]


@pytest.fixture
def rng():
    return np.random.default_rng(RNG_SEED)


def test_untouched_frame_is_the_careful_image(rng):
    careful = 1 + 0.3 * rng.random(SHAPE)
    cheap = careful + noise(rng)
    found = without_shared_noise(*images(cheap, cheap, careful))
    np.testing.assert_allclose(found, careful, atol=1e-6)


def test_frame_without_noise_in_the_untouched_images_stays(rng):
    careful, now = 1 + rng.random(SHAPE), 1 + rng.random(SHAPE)
    np.testing.assert_array_equal(without_shared_noise(*images(now, careful, careful)), now.astype(np.float32))


def test_foreign_noise_grows_by_less_than_a_hundredth(rng):
    # A plain control variate doubles its variance.
    careful, own = np.ones(SHAPE), noise(rng)
    found = without_shared_noise(*images(careful + own, careful + noise(rng), careful))
    assert np.var(found) < 1.01 * np.var(own)


@pytest.mark.parametrize("correlation", [0.5, 0.8])
def test_shared_part_is_taken_off(rng, correlation):
    careful, shared = np.ones(SHAPE), noise(rng)
    now = careful + correlation * shared + np.sqrt(1 - correlation**2) * noise(rng)
    found = without_shared_noise(*images(now, careful + shared, careful))
    assert np.var(found) == pytest.approx((1 - correlation**2) * np.var(shared), rel=0.03)


def test_a_change_far_greater_than_the_noise_keeps_its_mean(rng):
    careful, change = np.ones(SHAPE), np.zeros(SHAPE)
    change[25:35, 20:30] = 2.0
    found = []
    for _ in range(400):
        shared = noise(rng)
        found.append(without_shared_noise(*images(careful + change + shared, careful + shared, careful)))
    error = np.std(found, axis=0)[25:35, 20:30].mean() / np.sqrt(400)
    block = np.mean(found, axis=0)[25:35, 20:30]
    assert abs(block.mean() - 3) < 4 * error / np.sqrt(block.size / 3)


def test_crop_with_its_margin_is_the_crop_of_the_whole(rng):
    whole = images(*(1 + noise(rng) for _ in range(3)))
    part = [image[3:, 5:] for image in whole]
    inner = without_shared_noise(*part)[REACH_PX:, REACH_PX:]
    np.testing.assert_array_equal(inner, without_shared_noise(*whole)[3 + REACH_PX :, 5 + REACH_PX :])
