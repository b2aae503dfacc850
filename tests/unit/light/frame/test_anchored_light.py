"""A cheap light field made as good as a careful one of the untouched state, as far as it did not change."""

import numpy as np
import pytest

from magicsim.light.frame.anchored_light import anchored_light
from magicsim.light.transport.light_field import LightField

COUNTS = (12, 14, 6)
CELLS = int(np.prod(COUNTS))
NOISE = 0.1


def light(fluence):
    return LightField(fluence=fluence, body=np.zeros((1, 3)), irradiance=np.zeros((1, 3)))


def anchored(now, cheap, careful):
    """Fluence of one light alone."""
    states = ({"led": light(fluence)} for fluence in (now, cheap, careful))
    return anchored_light(*states, COUNTS, None)["led"].fluence


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
    cheap = noisy(careful, np.random.default_rng(1))
    np.testing.assert_allclose(anchored(cheap, cheap, careful), careful, rtol=1e-12)


def test_everything_brighter_by_a_factor_is_so_and_as_calm(careful):
    cheap = noisy(careful, np.random.default_rng(1))
    assert rms(anchored(1.2 * cheap, cheap, careful), 1.2 * careful) < 0.1 * NOISE


def test_change_that_is_noise_alone_is_left_out(careful):
    random = np.random.default_rng(1)
    errors = []
    for _ in range(20):
        now, cheap = noisy(careful, random), noisy(careful, random)
        smooth = anchored(now, careful, careful)  # of which no noise is known
        errors.append([rms(anchored(now, cheap, careful), careful), rms(smooth, careful)])
    told, smooth = np.mean(errors, 0)
    assert told < 0.5 * smooth
    assert smooth < 0.3 * NOISE


def test_change_that_is_ten_times_the_noise_is_kept(careful):
    random, x = np.random.default_rng(1), np.tile(np.arange(COUNTS[0]), CELLS // COUNTS[0])
    truth = careful * (1 + 0.2 * np.cos(np.pi * x / COUNTS[0]))[:, None]
    whole = anchored(truth, careful, careful) - careful
    found = anchored(noisy(truth, random), noisy(careful, random), careful)
    kept = float(((found - careful) * whole).sum() / (whole**2).sum())
    assert kept == pytest.approx(1, abs=0.03)


def test_change_is_kept_in_the_mean(careful):
    random, y = np.random.default_rng(1), np.tile(np.repeat(np.arange(COUNTS[1]), COUNTS[0]), COUNTS[2])
    truth = careful * (1 + 0.3 * y[:, None] / COUNTS[1])
    found = [anchored(noisy(truth, random), noisy(careful, random), careful) for _ in range(50)]
    assert np.mean(found) == pytest.approx(truth.mean(), rel=0.003)


def test_dark_cells_take_the_light_that_they_get(careful):
    dark = np.zeros_like(careful)
    np.testing.assert_array_equal(anchored(dark, dark, dark), dark)
    np.testing.assert_array_equal(anchored(careful, dark, dark), careful)


def test_squeezed_voxels_are_as_bright_as_before(careful):
    random = np.random.default_rng(1)
    held = np.ones((CELLS, 1))
    held[100:140] = 0.2
    cheap = noisy(careful, random)
    states = [
        {"led": LightField(fluence=careful, body=body, irradiance=np.zeros((1, 3)))}
        for body in (held * cheap, cheap, careful)
    ]
    body = anchored_light(*states, None, COUNTS, held)["led"].body
    np.testing.assert_allclose(body, held * careful, rtol=1e-9)


def test_half_of_a_noise_that_is_shared_in_half_is_taken_off(careful):
    # Half of the variance is common to both, so the best share is the correlation, and 1 - 1/4 of the variance stays.
    random, errors = np.random.default_rng(1), []
    x = np.tile(np.arange(COUNTS[0]), CELLS // COUNTS[0])
    truth = careful * (1 + 0.3 * np.cos(np.pi * x / COUNTS[0]))[:, None]  # so strong that all of it counts
    whole = anchored(truth, careful, careful)
    for _ in range(160):
        common, own, other = (np.sqrt(careful) * NOISE * random.standard_normal(careful.shape) for _ in range(3))
        now, cheap = truth + np.sqrt(0.5) * (common + own), careful + np.sqrt(0.5) * (common + other)
        alone, both = anchored(now, careful, careful), anchored(now, cheap, careful)
        errors.append([np.mean((field - whole) ** 2) for field in (both, alone)])
    both, alone = np.mean(errors, 0)
    assert both / alone == pytest.approx(0.75, abs=0.03)


def test_without_a_grid_the_careful_field_stands(careful):
    states = ({"led": light(fluence)} for fluence in (2 * careful, careful, careful))
    assert anchored_light(*states, None, None)["led"].fluence is careful


def test_brightness_of_all_is_not_lost_in_the_noise_between_cells(careful):
    # 1 % brighter, where local means have 2 % of noise, and the mean of all 0.6 %: about 1 / (1 + 0.6^2) of it is seen.
    random, lights = np.random.default_rng(1), ("left", "right", "top", "bottom")
    gains = []
    for _ in range(30):
        now, cheap = ({name: light(noisy(factor * careful, random)) for name in lights} for factor in (1.01, 1))
        found = anchored_light(now, cheap, {name: light(careful) for name in lights}, COUNTS, None)
        gains.append(sum(found[name].fluence.sum() for name in lights) / careful.sum() / len(lights) - 1)
    assert np.mean(gains) == pytest.approx(0.0074, abs=0.001)


def test_brightness_that_differs_by_noise_alone_is_left_out_in_part(careful):
    # Each light as a whole is brighter or darker by chance, and nothing else changes.
    random, lights = np.random.default_rng(1), ("left", "right", "top", "bottom")
    before, after = [], []
    for _ in range(200):
        now, cheap = ({name: 1 + 0.01 * random.standard_normal() for name in lights} for _ in range(2))
        states = [{name: light(one[name] * careful) for name in lights} for one in (now, cheap)]
        found = anchored_light(*states, {name: light(careful) for name in lights}, COUNTS, None)
        before += [now[name] - 1 for name in lights]
        after += [found[name].fluence.sum() / careful.sum() - 1 for name in lights]
    assert np.std(before) == pytest.approx(0.01, rel=0.1)
    assert np.std(after) < 0.8 * np.std(before)
