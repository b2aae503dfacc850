import numpy as np
import pytest

from magicsim.camera.disturbances import transmittance
from magicsim.camera.effect_settings import Dust


def passes(dust: Dust, seed: int = 0) -> np.ndarray:
    return transmittance(dust, rows=200, columns=150, pattern_seed=seed)


def test_specks_take_the_light_that_their_size_and_opacity_say():
    """Mean over many windows: n a/2 pi r^2 / 2 with the lognormal's mean square r^2 exp(2 sd^2); rims take a little."""
    dust = Dust(specks=6, radius_px=3.0, opacity=0.2)
    lost = np.mean([(1 - passes(dust, seed)).sum() for seed in range(600)])
    expected = 6 * 0.1 * np.pi * 9 * np.exp(2 * 0.25) / 2
    assert lost == pytest.approx(expected, rel=0.08)


def test_no_speck_takes_more_than_its_opacity_and_none_gives_light():
    found = passes(Dust(specks=1, radius_px=20.0, opacity=0.3))
    assert 0.7 <= found.min() < 1
    assert found.max() <= 1


def test_dust_stays_where_it_is_and_another_camera_has_other_dust():
    assert (passes(Dust(), 4) == passes(Dust(), 4)).all()
    assert (passes(Dust(), 4) != passes(Dust(), 5)).any()


def test_specks_lie_all_over_the_window():
    lost = sum(1 - passes(Dust(specks=20, radius_px=3.0, opacity=0.1), seed) for seed in range(100))
    quarters = [
        lost[rows, columns].sum() for rows in (slice(100), slice(100, None)) for columns in (slice(75), slice(75, None))
    ]
    assert np.std(quarters) / np.mean(quarters) < 0.1


def test_a_clean_window_lets_all_light_through():
    assert (passes(Dust(specks=0)) == 1).all()
