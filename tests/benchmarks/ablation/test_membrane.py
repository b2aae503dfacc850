import numpy as np
import pytest
from laboratory.ablation.membrane import ELEVATION_DEG, shade_membrane

from magicsim.scenes.rig import LedStrip

STRIPS = (LedStrip(side="-x", radiance=(2.0, 0, 0)), LedStrip(side="+y", radiance=(0, 3.0, 0)))


def landing() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-4, 4, 33), np.linspace(5, -5, 41))
    return np.stack([x, y], -1)


def test_flat_membrane_is_lit_evenly_by_the_sine_of_the_elevation():
    image = shade_membrane(np.zeros((41, 33)), landing(), STRIPS)
    expected = np.sin(np.radians(ELEVATION_DEG)) * np.array([2.0, 3.0, 0.0])
    assert image == pytest.approx(np.broadcast_to(expected, image.shape), rel=1e-6)


def test_slopes_that_face_a_light_brighten_and_those_that_turn_away_darken():
    """Pressed in towards +z, a cone falls off to all sides: its side at -x faces the light at -x."""
    x, y = np.moveaxis(landing(), -1, 0)
    image = shade_membrane(np.clip(2 - np.hypot(x, y), 0, None), landing(), STRIPS)
    flat = np.sin(np.radians(ELEVATION_DEG)) * np.array([2.0, 3.0])
    left, right = image[20, 12, 0], image[20, 20, 0]
    upper, lower = image[16, 16, 1], image[24, 16, 1]
    assert left > flat[0] > right
    assert upper > flat[1] > lower


def test_slope_of_45_degrees_obeys_lamberts_law():
    x, _ = np.moveaxis(landing(), -1, 0)
    image = shade_membrane(x, landing(), STRIPS)
    expected = 2.0 * np.cos(np.radians(45 - ELEVATION_DEG))
    assert image[5:-5, 5:-5, 0] == pytest.approx(expected, rel=1e-5)
