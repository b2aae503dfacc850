"""A cheap light field made as good as a careful one of the untouched state, as far as it did not change."""

import numpy as np
import pytest

from magicsim.scenes.light_field import LightField

COUNTS = (12, 14, 6)
CELLS = int(np.prod(COUNTS))
NOISE = 0.1


def light(fluence):
    return LightField(fluence=fluence, body=np.zeros((1, 3)), irradiance=np.zeros((1, 3)))


@pytest.fixture
def careful():
    """Falls along x, in one channel only, as light of one LED strip does."""
    x = np.tile(np.arange(COUNTS[0]), CELLS // COUNTS[0])
    return np.stack([np.exp(-x / 4), np.zeros(CELLS), np.zeros(CELLS)], 1)


def noisy(fluence, random):
    return np.maximum(fluence * (1 + NOISE * random.standard_normal(fluence.shape)), 0)


def rms(field, truth):
    return float(np.sqrt(((field - truth) ** 2).mean() / (truth**2).mean()))


def test_nothing_changed_gives_the_careful_field(careful):
    cheap = light(noisy(careful, np.random.default_rng(1)))
    anchored = cheap.anchored(cheap, light(careful), COUNTS, None)
    np.testing.assert_allclose(anchored.fluence, careful, rtol=1e-12)


def test_everything_brighter_by_a_factor_is_so_and_as_calm(careful):
    cheap = noisy(careful, np.random.default_rng(1))
    anchored = light(1.2 * cheap).anchored(light(cheap), light(careful), COUNTS, None)
    assert rms(anchored.fluence, 1.2 * careful) < 0.1 * NOISE


def test_noise_that_is_not_shared_is_not_added(careful):
    random = np.random.default_rng(1)
    errors = []
    for _ in range(20):
        now, cheap = noisy(careful, random), noisy(careful, random)
        alone = light(now).anchored(light(careful), light(careful), COUNTS, None)
        both = light(now).anchored(light(cheap), light(careful), COUNTS, None)
        errors.append([rms(both.fluence, careful), rms(alone.fluence, careful)])
    both, alone = np.mean(errors, 0)
    assert both < 1.02 * alone
    assert alone < 0.3 * NOISE


def test_change_is_kept_in_the_mean(careful):
    random, y = np.random.default_rng(1), np.tile(np.repeat(np.arange(COUNTS[1]), COUNTS[0]), COUNTS[2])
    truth = careful * (1 + 0.3 * y[:, None] / COUNTS[1])
    found = [
        light(noisy(truth, random)).anchored(light(noisy(careful, random)), light(careful), COUNTS, None).fluence
        for _ in range(50)
    ]
    assert np.mean(found) == pytest.approx(truth.mean(), rel=0.003)


def test_dark_cells_stay_as_they_were(careful):
    dark = np.zeros_like(careful)
    anchored = light(dark).anchored(light(dark), light(dark), COUNTS, None)
    np.testing.assert_array_equal(anchored.fluence, dark)
    assert np.isfinite(light(careful).anchored(light(dark), light(dark), COUNTS, None).fluence).all()


def test_without_a_grid_the_careful_field_stands(careful):
    assert light(2 * careful).anchored(light(careful), light(careful), None, None).fluence is careful
