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


def test_change_that_is_noise_alone_is_left_out(careful):
    random = np.random.default_rng(1)
    errors = []
    for _ in range(20):
        now, cheap = noisy(careful, random), noisy(careful, random)
        smooth = light(now).anchored(light(careful), light(careful), COUNTS, None)  # of which no noise is known
        told = light(now).anchored(light(cheap), light(careful), COUNTS, None)
        errors.append([rms(told.fluence, careful), rms(smooth.fluence, careful)])
    told, smooth = np.mean(errors, 0)
    assert told < 0.5 * smooth
    assert smooth < 0.3 * NOISE


def test_change_that_is_ten_times_the_noise_is_kept(careful):
    random, x = np.random.default_rng(1), np.tile(np.arange(COUNTS[0]), CELLS // COUNTS[0])
    truth = careful * (1 + 0.2 * np.cos(np.pi * x / COUNTS[0]))[:, None]
    whole = light(truth).anchored(light(careful), light(careful), COUNTS, None).fluence - careful
    found = light(noisy(truth, random)).anchored(light(noisy(careful, random)), light(careful), COUNTS, None).fluence
    kept = float(((found - careful) * whole).sum() / (whole**2).sum())
    assert kept == pytest.approx(1, abs=0.03)


def test_change_is_kept_in_the_mean(careful):
    random, y = np.random.default_rng(1), np.tile(np.repeat(np.arange(COUNTS[1]), COUNTS[0]), COUNTS[2])
    truth = careful * (1 + 0.3 * y[:, None] / COUNTS[1])
    found = [
        light(noisy(truth, random)).anchored(light(noisy(careful, random)), light(careful), COUNTS, None).fluence
        for _ in range(50)
    ]
    assert np.mean(found) == pytest.approx(truth.mean(), rel=0.003)


def test_dark_cells_take_the_light_that_they_get(careful):
    dark = np.zeros_like(careful)
    np.testing.assert_array_equal(light(dark).anchored(light(dark), light(dark), COUNTS, None).fluence, dark)
    np.testing.assert_array_equal(light(careful).anchored(light(dark), light(dark), COUNTS, None).fluence, careful)


def test_squeezed_voxels_are_as_bright_as_before(careful):
    random = np.random.default_rng(1)
    held = np.ones((CELLS, 1))
    held[100:140] = 0.2
    cheap = noisy(careful, random)
    fields = [
        LightField(fluence=careful, body=body, irradiance=np.zeros((1, 3))) for body in (held * cheap, cheap, careful)
    ]
    body = fields[0].anchored(fields[1], fields[2], None, COUNTS, held).body
    np.testing.assert_allclose(body, held * careful, rtol=1e-9)


def test_half_of_a_noise_that_is_shared_in_half_is_taken_off(careful):
    # Half of the variance is common to both, so the best share is the correlation, and 1 - 1/4 of the variance stays.
    random, errors = np.random.default_rng(1), []
    truth = 2 * careful  # a change so strong that all of it counts
    whole = light(truth).anchored(light(careful), light(careful), COUNTS, None).fluence
    for _ in range(40):
        common, own, other = (np.sqrt(careful) * NOISE * random.standard_normal(careful.shape) for _ in range(3))
        now, cheap = truth + np.sqrt(0.5) * (common + own), careful + np.sqrt(0.5) * (common + other)
        alone = light(now).anchored(light(careful), light(careful), COUNTS, None).fluence
        both = light(now).anchored(light(cheap), light(careful), COUNTS, None).fluence
        errors.append([np.mean((field - whole) ** 2) for field in (both, alone)])
    both, alone = np.mean(errors, 0)
    assert both / alone == pytest.approx(0.75, abs=0.03)


def test_without_a_grid_the_careful_field_stands(careful):
    assert light(2 * careful).anchored(light(careful), light(careful), None, None).fluence is careful
