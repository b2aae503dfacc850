"""Anchored images: the anchor one where nothing changed, all of a change's detail, crops that are exact."""

import numpy as np
import pytest

from magicsim.light.frame.frame_image import REACH_PX, anchored_image

SHAPE = (110, 100, 3)
RNG_SEED = 3
SIGMA = 0.1
EVERYWHERE = np.ones(SHAPE[:2], bool)


@pytest.fixture
def rng():
    return np.random.default_rng(RNG_SEED)


def noisy(rng, image):
    return (image + rng.normal(scale=SIGMA, size=SHAPE)).astype(np.float32)


def test_untouched_frame_is_the_careful_image(rng):
    anchor = (1 + 0.3 * rng.random(SHAPE)).astype(np.float32)
    control = noisy(rng, anchor)
    np.testing.assert_allclose(anchored_image(control, control, anchor, EVERYWHERE), anchor, atol=1e-6)


def test_detail_of_a_change_keeps_its_contrast_above_the_noise_of_the_frame(rng):
    # Dots of two pixels' period, five times the noise, of whose variance their part has 0.55: what smooths takes them
    # off, and so does a wrong noise.
    anchor = (1 + 0.3 * rng.random(SHAPE)).astype(np.float32)
    dots = 5 * SIGMA * np.where(np.indices(SHAPE[:2]).sum(0) % 2, 1.0, -1.0)[..., None] * np.ones(SHAPE)
    found = anchored_image(noisy(rng, anchor + dots), noisy(rng, anchor), anchor, EVERYWHERE) - anchor
    assert np.mean(found * dots) / np.mean(dots**2) == pytest.approx(25 / 25.55, abs=0.005)
    assert np.std(found - dots) < 1.02 * SIGMA


def test_radiance_is_not_negative(rng):
    dark = np.zeros(SHAPE, np.float32)
    assert anchored_image(noisy(rng, dark), noisy(rng, dark), dark, EVERYWHERE).min() >= 0


def test_pixels_that_cannot_have_changed_are_the_careful_ones(rng):
    anchor, changed = np.ones(SHAPE, np.float32), ~EVERYWHERE
    changed[40:50, 20:40] = True
    found = anchored_image(noisy(rng, anchor + 1), noisy(rng, anchor), anchor, changed)
    np.testing.assert_array_equal(found[~changed], anchor[~changed])
    assert found[changed].mean() == pytest.approx(2, abs=0.1)
    everywhere = anchored_image(noisy(rng, anchor), noisy(rng, anchor), anchor, ~EVERYWHERE)
    np.testing.assert_array_equal(everywhere, anchor)


@pytest.mark.parametrize("changed", [EVERYWHERE, np.indices(SHAPE[:2]).sum(0) % 110 > 75])
def test_crop_with_its_margin_is_the_crop_of_the_whole(rng, changed):
    whole = [noisy(rng, np.ones(SHAPE)) for _ in range(3)] + [changed]
    part = [image[3:, 5:] for image in whole]
    inner = anchored_image(*part)[REACH_PX:, REACH_PX:]
    np.testing.assert_array_equal(inner, anchored_image(*whole)[3 + REACH_PX :, 5 + REACH_PX :])
