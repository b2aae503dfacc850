import numpy as np
import pytest
from scipy.special import j1

from magicsim.camera.effect_settings import Diffraction, Glare
from magicsim.camera.film import aperture_transfer, spread_light


def point(rows: int, columns: int, at: tuple[int, int]) -> np.ndarray:
    image = np.zeros((rows, columns, 3), np.float32)
    image[at] = 1000.0
    return image


def test_a_point_becomes_the_airy_pattern_of_each_wavelength():
    """(2 J1(x) / x)^2 with x = pi r / (lambda N), an expression of its own beside the transfer."""
    diffraction = Diffraction(f_number=16.0, pixel_um=2.0, wavelengths_nm=(625.0, 530.0, 470.0))
    found = spread_light(point(129, 129, (64, 64)), diffraction, None)
    radius_um = 2.0 * np.hypot(*np.indices((129, 129)) - 64)
    for channel, wavelength_um in enumerate((0.625, 0.53, 0.47)):
        x = np.maximum(np.pi * radius_um / (wavelength_um * 16.0), 1e-9)
        # Power of the whole pattern over its peak: pi r^2 = 4 (lambda N)^2 / pi.
        peak = 1000 * np.pi / 4 * (2.0 / (wavelength_um * 16.0)) ** 2
        expected = peak * (2 * j1(x) / x) ** 2
        near = radius_um < 50
        assert found[..., channel][near] == pytest.approx(expected[near], abs=2e-3 * peak)


def test_the_limit_of_an_aperture_is_the_end_of_its_transfer():
    assert aperture_transfer(np.array([0.0, 1.0, 1.5])) == pytest.approx([1, 0, 0])
    low = np.array([1e-3])
    assert aperture_transfer(low) == pytest.approx(1 - 4 / np.pi * low, abs=1e-6)


def test_glare_takes_its_share_of_a_point_and_spreads_it_as_a_gaussian():
    found = spread_light(point(257, 257, (128, 128)), None, Glare(share=0.1, radius_px=12.0))[..., 0]
    assert found[128, 128] == pytest.approx(900 + 100 / (2 * np.pi * 144), rel=1e-4)
    squared = ((np.indices((257, 257)) - 128) ** 2).sum(0)
    around = squared > 0
    expected = 100 / (2 * np.pi * 144) * np.exp(-squared / 288)
    assert found[around] == pytest.approx(expected[around], abs=1e-4)


@pytest.mark.parametrize("at", [(0, 0), (20, 3), (30, 47)])
def test_no_light_is_lost_or_made(at: tuple[int, int]):
    found = spread_light(point(31, 48, at), Diffraction(f_number=11.0), Glare(share=0.3, radius_px=9.0))
    assert found.sum((0, 1)) == pytest.approx([1000] * 3, rel=1e-4)


def test_an_even_image_stays_as_it_is():
    even = np.full((20, 30, 3), 0.7, np.float32)
    assert spread_light(even, Diffraction(), Glare(share=0.5)) == pytest.approx(even, abs=1e-6)


def test_without_both_the_image_is_not_touched():
    image = point(8, 8, (2, 2))
    assert spread_light(image, None, None) is image
