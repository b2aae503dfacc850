import numpy as np
import pytest

from magicsim.camera.disturbances import flicker_share
from magicsim.camera.effect_settings import Flicker, Shutter


def shares(
    flicker: Flicker, shutter: Shutter, time_s: float = 0.0, *, rows: int = 40, rate: float = 15.0, seed: int = 3
):
    return flicker_share(flicker, shutter, rows=rows, time_s=time_s, frames_per_second=rate, seed=seed)


@pytest.mark.parametrize("exposure_ms", [0.5, 4.0, 13.0])
@pytest.mark.parametrize("row_us", [0.0, 70.0])
def test_rows_see_the_mean_of_the_light_while_they_are_open(exposure_ms: float, row_us: float):
    """Against the light itself, found from very short exposures, averaged over each row's time."""
    flicker, moments = Flicker(mains_hz=50.0, depth=0.3), 400
    ends = 0.123 - 1e-6 * row_us * np.arange(39, -1, -1)
    expected = []
    for end in ends:
        times = end - 1e-3 * exposure_ms * (np.arange(moments) + 0.5) / moments
        instant = Shutter(exposure_ms=1e-6)
        expected.append(np.mean([shares(flicker, instant, time, rows=1)[0] for time in times]))
    found = shares(flicker, Shutter(exposure_ms=exposure_ms, row_us=row_us), 0.123)
    assert found == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("mains_hz", "exposure_ms"), [(50.0, 10.0), (50.0, 20.0), (60.0, 1000 / 120)])
def test_whole_periods_of_the_light_hide_it(mains_hz: float, exposure_ms: float):
    found = shares(Flicker(mains_hz=mains_hz, depth=1.0), Shutter(exposure_ms=exposure_ms, row_us=30.0))
    assert np.abs(found).max() < 1e-12


def test_bands_repeat_after_as_many_rows_as_are_read_in_a_period():
    found = shares(Flicker(depth=0.2), Shutter(exposure_ms=2.0, row_us=100.0), rows=300)  # 10 ms: 100 rows
    assert found[100:] == pytest.approx(found[:-100])
    assert np.ptp(found) == pytest.approx(2 * 0.2 * np.sinc(0.2), rel=1e-3)


def test_a_global_shutter_shows_no_bands():
    assert np.ptp(shares(Flicker(), Shutter(exposure_ms=3.0))) == 0


def test_frames_at_a_part_of_the_frequency_see_the_same_swing():
    shutter = Shutter(exposure_ms=3.0, row_us=50.0)
    assert shares(Flicker(), shutter, 5 / 25, rate=25) == pytest.approx(shares(Flicker(), shutter, 6 / 25, rate=25))
    assert np.abs(shares(Flicker(), shutter, 5 / 15) - shares(Flicker(), shutter, 6 / 15)).max() > 0.01


def test_exposure_is_no_longer_than_a_frame():
    long, frame = (shares(Flicker(), Shutter(exposure_ms=each), rate=60.0) for each in (40.0, 1000 / 60))
    assert long == pytest.approx(frame)


def test_each_episode_begins_elsewhere_in_the_swing_and_the_mean_of_many_is_nothing():
    found = [shares(Flicker(depth=0.5), Shutter(exposure_ms=1.0), seed=seed)[0] for seed in range(400)]
    size = 0.5 * np.sinc(0.1)
    assert np.std(found) == pytest.approx(size / np.sqrt(2), rel=0.06)
    assert np.mean(found) == pytest.approx(0, abs=4 * size / np.sqrt(2 * 400))
