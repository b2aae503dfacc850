"""A cheap light field made as good as a careful one of the untouched state, as far as it did not change."""

import numpy as np
import pytest

from magicsim.light.frame.anchored_light import CHANGED_SHARE, Expected, anchored_light
from magicsim.light.transport.light_field import LightField

COUNTS = (12, 14, 6)
CELLS = int(np.prod(COUNTS))
NOISE = 0.1


def light(fluence):
    return LightField(fluence=fluence, body=np.zeros((1, 3)), irradiance=np.zeros((1, 3)))


def anchored(now, cheap, careful, share=None):
    """Fluence of one light alone, where a share of it comes from a contact."""
    states = (light(fluence) for fluence in (now, cheap, careful))
    expected = None if share is None else Expected(cells=np.full(CELLS, share), voxels=np.ones(1))
    return anchored_light(*states, COUNTS, None, expected=expected).fluence


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


def test_far_from_a_contact_noise_is_left_out(careful):
    random = np.random.default_rng(1)
    now, cheap = noisy(careful, random), noisy(careful, random)
    np.testing.assert_array_equal(anchored(now, cheap, careful, 0.0), careful)
    assert rms(anchored(now, cheap, careful, 0.002), careful) < 0.1 * rms(anchored(now, cheap, careful), careful)


def test_close_to_a_contact_a_change_is_kept(careful):
    random, x = np.random.default_rng(1), np.tile(np.arange(COUNTS[0]), CELLS // COUNTS[0])
    truth = careful * (1 + 0.2 * np.cos(np.pi * x / COUNTS[0]))[:, None]
    whole = anchored(truth, careful, careful) - careful
    for share, tolerance in ((None, 0.03), (1.0, 0.03), (0.5, 0.05)):
        found = anchored(noisy(truth, random), noisy(careful, random), careful, share)
        kept = float(((found - careful) * whole).sum() / (whole**2).sum())
        assert kept == pytest.approx(1, abs=tolerance)


def test_of_a_change_as_large_as_its_noise_half_is_kept(careful):
    """Wiener's filter where signal and noise are known to be alike, over lengths that hold almost all of both."""
    random, factors = np.random.default_rng(1), []
    for _ in range(40):
        now, cheap = (careful * (1 + 0.02 * random.standard_normal()) for _ in range(2))
        offset = abs(float((cheap - careful).sum() / careful.sum()))
        found = anchored(now, cheap, careful, offset / CHANGED_SHARE)
        share = np.clip((now - careful).sum() / (cheap - careful).sum(), 0, 1)
        left = (now - careful - share * (cheap - careful)).sum()
        if abs(left) > 1e-9 * careful.sum():
            factors.append((found - careful).sum() / left * (2 - share**2))
    np.testing.assert_allclose(factors, 1, rtol=1e-6)
    assert len(factors) > 20


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
        LightField(fluence=careful, body=body, irradiance=np.zeros((1, 3))) for body in (held * cheap, cheap, careful)
    ]
    body = anchored_light(*states, None, COUNTS, growth=held).body
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
    states = (light(fluence) for fluence in (2 * careful, careful, careful))
    assert anchored_light(*states, None, None).fluence is careful


def test_expected_size_is_that_of_the_lit_cells(careful):
    even = Expected(cells=np.full(CELLS, 0.4), voxels=np.ones(1))
    assert even.size(careful) == pytest.approx(0.4 * CHANGED_SHARE)
    lit = np.zeros((CELLS, 3))
    lit[0] = (1, 2, 3)
    lit[1] = (0, 6, 0)
    far = Expected(cells=np.concatenate([[0.1, 0.3], np.ones(CELLS - 2)]), voxels=np.ones(1))
    assert far.size(lit) == pytest.approx(CHANGED_SHARE * np.sqrt((0.1**2 + 0.3**2) / 2))
    assert far.size(np.zeros((CELLS, 3))) == 0
