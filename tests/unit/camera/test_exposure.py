import numpy as np
import pytest

from magicsim.camera.camera import Camera
from magicsim.camera.exposure import expose, meter
from magicsim.errors import RenderError

UNIT = np.ones(3)
SILENT = {"full_well_e": 1e12, "read_noise_e": 0.0, "fixed_pattern": 0.0}


def flat(*levels: float, size: int = 60) -> np.ndarray:
    return np.broadcast_to(np.array(levels, np.float32), (size, size, 3)).copy()


def take(radiance: np.ndarray, camera: Camera, exposure: np.ndarray = UNIT, *, seed: int = 0, frame: int = 0):
    return expose(radiance, exposure, camera, seed=seed, frame=frame)


@pytest.mark.parametrize("gamma", [1.0, 2.2, 0.5])
@pytest.mark.parametrize("aim", [40.0, 90.0, 200.0])
def test_untouched_sensor_comes_out_at_the_grey_level_aimed_at(gamma: float, aim: float):
    camera = Camera(exposure_grey=aim, gamma=gamma, **SILENT)
    untouched = flat(0.02, 5.0, 0.3)
    image = take(untouched, camera, meter(untouched, camera))
    assert image.mean((0, 1)) == pytest.approx([aim] * 3, abs=0.5)


def test_white_balance_off_keeps_the_ratios_of_the_channels():
    camera = Camera(white_balance=False, **SILENT)
    untouched = flat(0.1, 0.2, 0.3)
    image = take(untouched, camera, meter(untouched, camera))
    assert image[0, 0].tolist() == [45, 90, 135]


def test_exposure_is_locked_so_that_twice_the_light_is_twice_as_bright():
    camera = Camera(**SILENT)
    exposure = meter(flat(0.1, 0.1, 0.1), camera)
    assert take(flat(0.2, 0.2, 0.2), camera, exposure)[0, 0].tolist() == [180] * 3


def test_tone_curve_follows_gamma():
    camera = Camera(gamma=2.0, **SILENT)
    assert take(flat(0.25, 0.04, 1.0), camera)[0, 0].tolist() == [128, 51, 255]


def test_signal_is_clipped_to_eight_bits():
    image = take(flat(50.0, 1.01, -0.3), Camera(**SILENT))
    assert image.dtype == np.uint8
    assert image[0, 0].tolist() == [255, 255, 0]


@pytest.mark.parametrize("untouched", [flat(0.1, 0.0, 0.1), flat(0.1, np.nan, 0.1), flat(0.1, np.inf, 0.1)])
def test_sensor_without_light_in_a_channel_cannot_be_metered(untouched: np.ndarray):
    with pytest.raises(RenderError, match="auto-exposure fails"):
        meter(untouched, Camera())


@pytest.mark.parametrize(("signal", "read_noise_e"), [(0.5, 0.0), (0.25, 0.0), (0.5, 40.0)])
def test_noise_variance_is_shot_plus_read_noise(signal: float, read_noise_e: float):
    well = 2000.0
    camera = Camera(full_well_e=well, read_noise_e=read_noise_e, fixed_pattern=0.0)
    image = take(flat(signal, signal, signal, size=150), camera).astype(float)
    electrons = signal * well
    expected = (255 / well) ** 2 * (electrons + read_noise_e**2) + 1 / 12  # and rounding to grey levels
    # 67500 samples: the variance is known to 0.54 %, the mean to a hundredth of its deviation
    assert image.var() == pytest.approx(expected, rel=0.025)
    assert image.mean() == pytest.approx(255 * signal, abs=5 * np.sqrt(expected / image.size))


def test_noise_is_independent_between_pixels_and_channels():
    camera = Camera(full_well_e=2000.0, read_noise_e=0.0, fixed_pattern=0.0)
    image = take(flat(0.5, 0.5, 0.5, size=150), camera).astype(float)
    image -= image.mean()
    for neighbour in (np.roll(image, 1, 0), np.roll(image, 1, 1), np.roll(image, 1, 2)):
        assert abs(np.corrcoef(image.ravel(), neighbour.ravel())[0, 1]) < 0.02


def test_same_seed_and_frame_give_the_same_bytes():
    radiance = flat(0.3, 0.4, 0.5)
    assert np.array_equal(take(radiance, Camera(), seed=3, frame=7), take(radiance, Camera(), seed=3, frame=7))


def test_every_frame_and_every_seed_has_noise_of_its_own():
    radiance = flat(0.3, 0.4, 0.5)
    camera = Camera(full_well_e=2000.0, fixed_pattern=0.0)
    images = [take(radiance, camera, seed=seed, frame=frame).astype(float) for seed in (0, 1) for frame in (0, 1)]
    residuals = [(image - image.mean((0, 1))).ravel() for image in images]
    correlation = np.corrcoef(residuals)
    assert np.abs(correlation[~np.eye(4, dtype=bool)]).max() < 0.05


def test_fixed_pattern_belongs_to_the_camera_and_not_to_the_episode():
    camera = Camera(full_well_e=1e12, read_noise_e=0.0, fixed_pattern=0.05)
    radiance = flat(0.5, 0.5, 0.5)
    first = take(radiance, camera, seed=1, frame=0)
    second = take(radiance, camera, seed=2, frame=9)
    assert np.abs(first.astype(int) - second).max() <= 1  # rounding alone
    assert first.std() / first.mean() == pytest.approx(0.05, rel=0.05)
    other = take(radiance, camera.model_copy(update={"pattern_seed": 1}), seed=1, frame=0)
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.05


def test_channel_in_which_no_light_shines_is_exposed_like_the_others():
    gain = meter(flat(0.1, 0.0, 0.3), Camera(), (True, False, True))
    assert gain[1] == pytest.approx(90 / 255 / 0.2)
    assert gain[[0, 2]] == pytest.approx(90 / 255 / np.array([0.1, 0.3]))


def test_where_no_light_arrives_a_radiance_of_one_comes_to_the_grey_level_aimed_at():
    camera = Camera(**SILENT)
    image = take(flat(1.0, 1.0, 1.0), camera, meter(flat(0.0, 0.0, 0.0), camera))
    assert image[0, 0].tolist() == [90] * 3


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_image_that_is_not_finite_becomes_no_frame(value: float):
    with pytest.raises(RenderError, match="holds 3600 values that are not finite"):
        take(flat(0.1, value, 0.1), Camera())
