import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.sweep.designs import list_designs
from magicsim.sweep.texture import (
    LOOKED_AT_PERIODS,
    PatternPowers,
    PlateFrames,
    observe,
    plate,
    plate_rig,
    powers,
    press_as_asked,
    smallest_spacing,
    told_apart_to,
    try_finest_first,
)
from sweep.fakes import small_sweep


def places(spacing_mm: float) -> np.ndarray:
    side = np.linspace(-0.5, 0.5, 60) * LOOKED_AT_PERIODS * spacing_mm
    return np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)


PLACES = places(1.0)


def frames(pattern: np.ndarray, noise: float, seed: int) -> PlateFrames:
    random = np.random.default_rng(seed)
    contrast = pattern[None, :, None] + random.normal(0, noise, (6, len(PLACES), 3))
    return PlateFrames(contrast=contrast, places_mm=PLACES, picture=np.zeros((4, 4, 3), np.uint8))


def test_power_of_a_wave_is_the_square_of_its_amplitude_in_its_direction_alone():
    wave = 0.3 * np.cos(2 * np.pi * PLACES[:, 0] + 0.7)
    found = powers(np.tile(wave[None, :, None], (2, 1, 3)), PLACES, (0.0, 60.0, 90.0), 1.0)
    assert found[0] == pytest.approx(0.09, rel=0.02)
    assert found[1:].max() < 1e-4


def test_lines_stand_out_of_noise_and_a_plate_without_them_does_not():
    lines = 0.05 * np.cos(2 * np.pi * PLACES[:, 0])
    plain = frames(np.zeros(len(PLACES)), 0.1, 1)
    assert observe(frames(lines, 0.1, 2), plain, "lines", 1.0).d_prime() > 4
    assert observe(frames(0 * lines, 0.1, 3), plain, "lines", 1.0).d_prime() < 2


def test_own_pattern_is_no_clutter():
    lines = 0.05 * np.cos(2 * np.pi * PLACES[:, 0])
    dots = lines + 0.05 * np.cos(2 * np.pi * PLACES[:, 1])
    plain = frames(np.zeros(len(PLACES)), 0.0, 1)
    for pattern, image in (("lines", lines), ("dots", dots)):
        found = observe(frames(image, 0.0, 2), plain, pattern, 1.0)
        assert found.around.max() < 0.01 * found.pattern


def test_what_the_plain_plate_shows_too_is_no_pattern():
    grid = 0.5 * np.cos(2 * np.pi * PLACES[:, 0])
    found = observe(frames(grid, 0.05, 2), frames(grid, 0.05, 1), "lines", 1.0)
    assert found.d_prime() < 2


def test_clutter_alone_reaches_the_threshold_in_about_one_case_of_twenty():
    random = np.random.default_rng(0)
    power = random.exponential(1.0, (4000, 12))
    told = [PatternPowers(pattern=float(row[0]), around=row[1:]).d_prime() >= 2 for row in power]
    assert 0.03 < np.mean(told) < 0.1


@pytest.mark.parametrize(
    ("d_prime", "expected"),
    [((4, 3, 2.5), 0.25), ((4, 3, 1), 0.5 * 0.5**0.5), ((1, 5, 5), 0.25), ((3, 1, 1), 0.5**0.5), ((1, 1, 1), np.inf)],
)
def test_smallest_spacing_lies_between_the_finest_told_apart_and_the_next(d_prime: tuple[float, ...], expected: float):
    assert told_apart_to(np.array([1.0, 0.5, 0.25]), np.array(d_prime, float)) == pytest.approx(expected)


def test_no_coarser_spacing_is_tried_than_needed():
    tried = []

    def is_told_apart(spacing: float) -> bool:
        tried.append(spacing)
        return spacing >= 1.4

    try_finest_first((2.0, 1.4, 1.0), is_told_apart)
    assert tried == [1.0, 1.4]


def test_bounds_say_that_they_are_bounds():
    clutter = np.ones(10)
    seen, unseen = PatternPowers(pattern=9.0, around=clutter), PatternPowers(pattern=1.0, around=clutter)
    spacings = np.array([1.0, 0.5])
    below = smallest_spacing(spacings, [seen, seen], seed=1)
    assert (below.value, below.low, below.high) == (0.5, None, 0.5)
    above = smallest_spacing(spacings, [unseen, unseen], seed=1)
    assert (above.value, above.low, above.high) == (None, 1.0, None)
    between = smallest_spacing(spacings, [seen, unseen], seed=1)
    assert 0.5 < between.low <= between.value <= between.high < 1.0


def test_patterns_are_half_as_wide_as_their_spacing_and_look_like_the_object():
    sweep = small_sweep("object.color=[0.1,0.2,0.3]")
    assert plate("lines", 0.6).width_mm == pytest.approx(0.3)
    assert plate("dots", 0.6).radius_mm == pytest.approx(0.15)
    assert plate("dots", 0.6, sweep.object).color == (0.1, 0.2, 0.3)


def test_camera_reads_out_the_plate_and_little_more():
    sweep = small_sweep("design.footprint_mm=[12,16]", "rig.camera.field_mm=10")
    camera = plate_rig(list_designs(sweep)[0].sensor, 1.4, sweep.quality).camera
    assert (camera.columns, camera.rows) == (48, 64)
    width = camera.region_px[2] * 10 / 48
    assert 7.0 < width < 8.5


def test_fine_patterns_get_as_many_pixels_as_they_need_and_the_camera_has():
    settings = ["design.footprint_mm=[12,16]", "rig.camera.field_mm=10"]
    sweep = small_sweep(*settings)
    assert plate_rig(list_designs(sweep)[0].sensor, 0.3, sweep.quality).camera.columns == 3 * 48
    few = small_sweep(*settings, "rig.camera.columns=60", "rig.camera.rows=80")
    with pytest.raises(ConfigError, match=r"columns = 60 is too few for 0\.3 mm: must be at least 100"):
        plate_rig(list_designs(few)[0].sensor, 0.3, few.quality)


@pytest.mark.parametrize(("force_n", "deepest_mm"), [(0.4, 2.0), (50.0, 0.2)])
def test_plates_are_pressed_with_a_force_or_as_deep_as_the_print_bears(force_n: float, deepest_mm: float):
    sweep = small_sweep(
        "design.footprint_mm=[8,8]",
        f"design.limits.depth_mm={deepest_mm}",
        "design.limits.sharp_depth_mm=0.1",
        f"quality.texture_force_n={force_n}",
    )
    pressed, depth_mm = press_as_asked(
        list_designs(sweep)[0].sensor.design, plate("lines", 0.8), sweep.quality, spacing_mm=0.8
    )
    if force_n == 50:
        assert depth_mm == deepest_mm
    else:
        assert depth_mm < deepest_mm
        assert pressed.force_n[2] == pytest.approx(force_n, rel=0.05)
