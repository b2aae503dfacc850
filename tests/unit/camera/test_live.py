import numpy as np
import pytest

from magicsim.camera.effect_settings import LiveExposure
from magicsim.camera.stream import corrected, metered, settled
from magicsim.errors import RenderError

EXACT = {"tolerance": 0.0}


def flat(*levels: float, size: int = 8) -> np.ndarray:
    return np.broadcast_to(np.array(levels, np.float32), (size, size, 3)).copy()


def followed(image: np.ndarray, live: LiveExposure, frames: int, *, aim: float, first: np.ndarray) -> list[np.ndarray]:
    """Signals of a steady image, frame by frame."""
    gains, found = (first,), []
    for _ in range(frames):
        means = metered(image, gains[0], live.metering)
        found.append(means)
        chosen = corrected(gains[-1], means, live, aim=aim, first=first)
        gains = (*gains, chosen)[-1 - live.delay_frames :]
    return found


@pytest.mark.parametrize("frames", [2.0, 6.0])
@pytest.mark.parametrize("light", [0.3, 2.5])
def test_a_step_of_light_decays_to_one_over_e_in_the_time_constant(frames: float, light: float):
    live = LiveExposure(time_constant_frames=frames, white_balance=False, delay_frames=0, **EXACT)
    found = followed(flat(0.2 * light, 0.2 * light, 0.2 * light), live, 13, aim=0.2, first=np.ones(3))
    errors = np.log(np.array(found)[:, 0] / 0.2)
    assert errors == pytest.approx(np.log(light) * np.exp(-np.arange(13) / frames), rel=1e-5)


@pytest.mark.parametrize("delay", [1, 2, 4])
def test_a_late_gain_swings_as_the_recursion_says(delay: int):
    live = LiveExposure(time_constant_frames=4.0, white_balance=False, delay_frames=delay, **EXACT)
    found = followed(flat(0.3, 0.3, 0.3), live, 40, aim=0.2, first=np.ones(3))
    errors = [np.log(1.5)] * (delay + 1)
    for _ in range(40):
        errors.append(errors[-1] - (1 - np.exp(-1 / 4)) * errors[-1 - delay])
    assert np.log(np.array(found)[:, 0] / 0.2) == pytest.approx(errors[:40], abs=1e-5)


def test_white_balance_brings_all_channels_to_one_mean_and_leaves_the_brightness():
    live = LiveExposure(exposure=False, white_balance_frames=5.0, **EXACT)
    found = followed(flat(0.1, 0.2, 0.3), live, 200, aim=0.2, first=np.ones(3))
    assert found[-1] == pytest.approx([(0.1 * 0.2 * 0.3) ** (1 / 3)] * 3, rel=1e-4)


def test_gain_stays_within_its_limits():
    live = LiveExposure(gain_limits=(0.5, 2.0), time_constant_frames=1.0, **EXACT)
    dark, bright = (followed(flat(*[each] * 3), live, 60, aim=0.2, first=np.ones(3))[-1] for each in (0.01, 0.9))
    assert dark == pytest.approx([0.02] * 3)
    assert bright == pytest.approx([0.45] * 3)


def test_an_error_within_the_tolerance_is_left():
    live = LiveExposure(tolerance=0.1)
    means, gain = np.full(3, 0.2 * np.exp(0.09)), np.ones(3)
    assert (corrected(gain, means, live, aim=0.2, first=gain) == gain).all()
    assert (corrected(gain, 1.1 * means, live, aim=0.2, first=gain) < gain).all()


def test_the_centre_counts_more_than_the_rim_by_the_gaussian_of_its_distance():
    places = np.arange(-60, 61)
    weight = np.exp(-((places / 60) ** 2) / (2 * 0.5**2))
    for row, column in ((60, 60), (60, 90), (10, 30)):
        spot = np.zeros((121, 121, 3), np.float32)
        spot[row, column] = 0.5
        expected = 0.5 * weight[row] * weight[column] / weight.sum() ** 2
        assert metered(spot, np.ones(3), "centre") == pytest.approx([expected] * 3)
        assert metered(spot, np.ones(3), "mean") == pytest.approx([0.5 / 121**2] * 3)


def test_what_is_saturated_is_metered_as_white():
    assert metered(flat(50.0, 0.5, 0.1), np.ones(3), "mean") == pytest.approx([1.0, 0.5, 0.1])


def test_exposure_settles_at_its_aim_where_some_pixels_are_saturated():
    image = flat(0.1, 0.1, 0.1)
    image[0] = 40.0  # an LED seen directly: an eighth of the image is white
    gain = settled(image, LiveExposure(), aim=0.4, first=np.ones(3))
    assert metered(image, gain, "mean").mean() == pytest.approx(0.4, rel=1e-3)
    assert gain == pytest.approx([(0.4 - 1 / 8) / (7 / 8) / 0.1] * 3, rel=1e-3)


@pytest.mark.parametrize("slow", [{"time_constant_frames": 5000.0}, {"white_balance_frames": 5000.0}])
def test_a_slow_camera_settles_where_a_quick_one_does(slow):
    image = flat(0.1, 0.2, 0.4)
    image[3:5, 3:5] *= 3
    live = LiveExposure(metering="centre", tolerance=0.0)
    quick = settled(image, live, aim=0.3, first=np.ones(3))
    found = settled(image, live.model_copy(update=slow), aim=0.3, first=np.ones(3))
    assert found == pytest.approx(quick, rel=3e-4)


def test_what_the_limits_cannot_reach_is_one_line():
    image = flat(0.0, 0.0, 0.0)
    image[0] = 40.0
    with pytest.raises(RenderError, match=r"never settles.*gain_limits = \[0\.25, 8\.0\].*exposure_grey") as error:
        settled(image, LiveExposure(), aim=0.4, first=np.ones(3))
    assert len(str(error.value).splitlines()) == 1


def test_a_colour_without_light_keeps_its_gain():
    live = LiveExposure(exposure=False)
    gain = corrected(np.ones(3), np.array([0.1, 0.0, 0.3]), live, aim=0.2, first=np.ones(3))
    assert gain[1] == 1
    assert gain[0] > 1 > gain[2]


def test_a_dark_sensor_keeps_its_first_gains():
    assert (settled(flat(0, 0, 0), LiveExposure(), aim=0.4, first=np.full(3, 0.4)) == 0.4).all()
