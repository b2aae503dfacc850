"""What of a frame's difference is a change: all of it where there is no noise, next to none of what is noise."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from magicsim.light.frame.frame_image import LENGTHS_PX, change_beyond_noise

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
    change = change_beyond_noise(*images(cheap, cheap, careful))
    np.testing.assert_allclose(change, 0, atol=1e-6)


def test_frame_without_noise_in_the_untouched_images_stays(rng):
    now, careful = images(1 + rng.random(SHAPE), 1 + rng.random(SHAPE))
    change = change_beyond_noise(now, careful, careful)
    np.testing.assert_allclose(change, now.astype(np.float64) - careful, atol=1e-12)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_noise_alone_is_no_change(rng, correlation):
    # A hundred pixels around tell its variance: a tenth of its size is left. Without the filter all of it stays.
    careful, shared = np.ones(SHAPE), noise(rng)
    now = careful + correlation * shared + np.sqrt(1 - correlation**2) * noise(rng)
    change = change_beyond_noise(*images(now, careful + shared, careful))
    assert np.std(change) < 0.2 * np.sqrt(1 - correlation**2) * SIGMA


def left_of_noise(width_px):
    """Variance of white noise above a Gaussian mean along one axis, and below it."""
    mean = gaussian_filter1d(np.eye(1, 401, 200)[0], width_px)
    return 1 - 2 * mean[200] + np.sum(mean**2), np.sum(mean**2)


@pytest.mark.parametrize("strength", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("kind", ["dots", "walls"])
def test_detail_counts_as_wiener_filter_has_it(rng, strength, kind):
    # A pattern of two pixels' period and strength s in noise of variance n^2: s^2 / (s^2 + n^2) of it is shown. n^2 is
    # what is left of the noise in the part that the pattern is in: dots are short both ways, a wall is long one way.
    across, down = np.resize([1.0, -1.0], SHAPE[1]), np.resize([1.0, -1.0], SHAPE[0])
    above, below = left_of_noise(LENGTHS_PX[1])[0], left_of_noise(LENGTHS_PX[2])[1]
    column = {"dots": down, "walls": np.ones(SHAPE[0])}[kind][:, None, None]
    variance = above * {"dots": above, "walls": below}[kind]
    pattern = strength * SIGMA * column * across[None, :, None] * np.ones(SHAPE)
    careful = np.ones(SHAPE)
    change = change_beyond_noise(*images(careful + pattern + noise(rng), careful + noise(rng), careful))
    shown = strength**2 / (strength**2 + variance)
    assert np.mean(change * pattern) / np.mean(pattern**2) == pytest.approx(shown, abs=0.04)
    assert np.sqrt(np.mean((change - pattern) ** 2)) < 1.1 * SIGMA * min(1.0, strength)


def test_what_is_smooth_is_shown_whole_however_faint(rng):
    across = np.linspace(-1, 1, SHAPE[1])[None, :, None] * np.ones(SHAPE)
    careful, change = np.ones(SHAPE), 0.5 * SIGMA * across
    found = change_beyond_noise(*images(careful + change + noise(rng), careful + noise(rng), careful))
    inner = (slice(8, -8), slice(8, -8))
    assert np.sum(found[inner] * across[inner]) / np.sum(change[inner] * across[inner]) == pytest.approx(1, abs=0.1)


def test_dimmed_frame_with_all_of_the_noise_keeps_none(rng):
    careful = np.ones(SHAPE)
    cheap = careful + noise(rng)
    change = change_beyond_noise(*images(0.2 * cheap, cheap, careful))
    np.testing.assert_allclose(change, -0.8, atol=1e-6)


def test_a_change_far_greater_than_the_noise_keeps_its_mean(rng):
    careful, change = np.ones(SHAPE), np.zeros(SHAPE)
    change[25:35, 20:30] = 2.0
    found = []
    for _ in range(100):
        shared = noise(rng)
        found.append(change_beyond_noise(*images(careful + change + shared, careful + shared, careful)))
    # Four hundred times the noise's variance: the filter takes off a quarter per cent, and more where its edges are.
    mean = np.mean(found, axis=0) - change
    for block in (mean[25:35, 20:30], mean[:2], mean[:, -2:], mean[:3, :3]):
        assert abs(block.mean()) < 0.005 * change.max()
