from dataclasses import replace

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.sweep import texture
from magicsim.sweep.designs import camera_of, list_designs
from magicsim.sweep.texture import (
    LOOKED_AT_PERIODS,
    TOLD_APART,
    Pattern,
    PatternPowers,
    PlateFrames,
    observe,
    plane_waves,
    plate,
    plate_rig,
    press_as_asked,
    smallest_spacing,
    told_apart_to,
)
from sweep.fakes import small_sweep


def places(spacing_mm: float) -> np.ndarray:
    side = np.linspace(-0.5, 0.5, 60) * LOOKED_AT_PERIODS * spacing_mm
    return np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)


PLACES = places(1.0)
COARSE = PLACES.reshape(60, 60, 2)[1::3, 1::3].reshape(-1, 2)


def frames(pattern: np.ndarray, noise: float, seed: int) -> PlateFrames:
    random = np.random.default_rng(seed)
    contrast = pattern[None, :, None] + random.normal(0, noise, (6, len(PLACES), 3))
    return PlateFrames(contrast=contrast, places_mm=PLACES, picture=np.zeros((4, 4, 3), np.uint8))


def test_power_of_a_wave_is_the_square_of_its_amplitude_in_its_direction_alone():
    wave = 0.3 * np.cos(2 * np.pi * PLACES[:, 0] + 0.7)
    found = np.abs(wave @ plane_waves(PLACES, (0.0, 60.0, 90.0), 1.0)) ** 2
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


ARE_ALIKE = pytest.mark.parametrize("alike", [0.0, 0.7, 1.0], ids=lambda share: f"{share:g} of the colours alike")


def presses(pattern: Pattern, d_primes: tuple[float, ...], alike: float, seed: int) -> list[PatternPowers]:
    """One press at each spacing in white clutter that draws and, in part, colours have in common."""
    random = np.random.default_rng(seed)
    places, found = COARSE, []
    window = np.prod(np.cos(np.pi * places / LOOKED_AT_PERIODS) ** 2, axis=1)
    power = 4 * (window**2).sum() / window.sum() ** 2  # of white clutter
    for d_prime in d_primes:
        axes = places if pattern == "dots" else places[:, :1]
        wave = d_prime * np.sqrt(power / 2) * np.cos(2 * np.pi * axes + 0.4).sum(1)
        own, common = random.normal(size=(len(places), 3)), random.normal(size=(len(places), 1))
        clutter = np.sqrt(1 - alike) * own + np.sqrt(alike) * common
        contrast = wave[:, None] + clutter + random.normal(0, 0.1, (4, len(places), 3))
        frames = PlateFrames(contrast=contrast, places_mm=places, picture=np.zeros((4, 4, 3), np.uint8))
        found.append(observe(frames, replace(frames, contrast=np.zeros_like(contrast)), pattern, 1.0))
    return found


@ARE_ALIKE
@pytest.mark.parametrize("pattern", ["lines", "dots"])
def test_interval_of_the_smallest_spacing_holds_it_in_nineteen_of_twenty_sweeps(pattern: Pattern, alike: float):
    # 300 sweeps: three standard deviations below 95 % are 91.2 %.
    spacings, d_primes = np.array([2.0, 1.4, 1.0]), (14.0, 6.0, 1.0)
    true, covered = float(told_apart_to(spacings, np.array(d_primes))), []
    closed = []
    for seed in range(300):
        observed = presses(pattern, d_primes, alike, seed)
        seen = next((number for number in (2, 1, 0) if observed[number].d_prime() >= TOLD_APART), 0)
        found = smallest_spacing(spacings[seen:], observed[seen:], seed=seed)
        covered.append((found.low or 0.0) <= true <= (found.high or np.inf))
        closed.append(found.high is not None)
    assert np.mean(covered) > 0.912
    assert np.mean(closed) > 0.4  # an open interval holds everything


@ARE_ALIKE
@pytest.mark.parametrize("pattern", ["lines", "dots"])
def test_confidence_distribution_of_d_prime_is_no_narrower_than_its_errors(pattern: Pattern, alike: float):
    ends = [presses(pattern, (5.0,), alike, seed)[0].allowed(np.array([0.025, 0.975])) for seed in range(400)]
    assert np.mean([low <= 5.0 <= high for low, high in ends]) > 0.917  # three standard deviations below 95 %


@ARE_ALIKE
def test_clutter_that_is_alike_in_part_seldom_reaches_the_threshold(alike: float):
    told = [presses("lines", (0.0,), alike, seed)[0].d_prime() >= TOLD_APART for seed in range(400)]
    assert np.mean(told) < 0.15


def test_clutter_alone_reaches_the_threshold_in_about_one_case_of_twenty():
    random = np.random.default_rng(0)
    told = [
        PatternPowers(pattern=float(row[0]), around=row[1:], pattern_parts=1.0, clutter_parts=11.0).d_prime() >= 2
        for row in random.exponential(1.0, (4000, 12))
    ]
    assert 0.03 < np.mean(told) < 0.1


@pytest.mark.parametrize(
    ("d_prime", "expected"),
    [((4, 3, 2.5), 0.25), ((4, 3, 1), 0.5 * 0.5**0.5), ((1, 5, 5), 0.25), ((3, 1, 1), 0.5**0.5), ((1, 1, 1), np.inf)],
)
def test_smallest_spacing_lies_between_the_finest_told_apart_and_the_next(d_prime: tuple[float, ...], expected: float):
    assert told_apart_to(np.array([1.0, 0.5, 0.25]), np.array(d_prime, float)) == pytest.approx(expected)


def test_bounds_say_that_they_are_bounds():
    def powers(pattern: float) -> PatternPowers:
        return PatternPowers(pattern=pattern, around=np.ones(10), pattern_parts=3.0, clutter_parts=12.0)

    seen, unseen = powers(200.0), powers(0.3)
    spacings = np.array([1.0, 0.5])
    below = smallest_spacing(spacings, [seen, seen], seed=1)
    assert (below.value, below.low, below.high) == (0.5, None, 0.5)
    above = smallest_spacing(spacings, [unseen, unseen], seed=1)
    assert (above.value, above.low, above.high) == (None, 1.0, None)
    between = smallest_spacing(spacings, [seen, unseen], seed=1)
    assert 0.5 < between.low <= between.value <= between.high < 1.0
    open_ended = smallest_spacing(spacings, [powers(4.0), powers(2.9)], seed=1)
    assert (open_ended.low, open_ended.high) == (None, None)
    assert 0.5 < open_ended.value < 1.0


def test_patterns_are_half_as_wide_as_their_spacing_and_look_like_the_object():
    sweep = small_sweep("object.color=[0.1,0.2,0.3]")
    assert plate("lines", 0.6).width_mm == pytest.approx(0.3)
    assert plate("dots", 0.6).radius_mm == pytest.approx(0.15)
    assert plate("dots", 0.6, sweep.object).color == (0.1, 0.2, 0.3)


def test_noise_of_the_plain_plate_is_not_that_of_the_pattern(monkeypatch: pytest.MonkeyPatch):
    class FakeSensor:
        def __init__(self, *_: object, **__: object) -> None:
            self.rest = None

        def radiance(self, *_: object) -> np.ndarray:
            return np.full((64, 48, 3), 0.3, np.float32)

    monkeypatch.setattr(texture, "Sensor", FakeSensor)
    monkeypatch.setattr(texture, "press_as_asked", lambda *_, **__: (None, 0.3))
    monkeypatch.setattr(texture, "moved", lambda *_: None)
    monkeypatch.setattr(texture, "sensor_exposure", lambda *_: np.ones(3))
    monkeypatch.setattr(texture, "pixel_landing_mm", lambda *_: np.zeros((64, 48, 2)))
    sweep = small_sweep()
    sensor = list_designs(sweep)[0].sensor
    monkeypatch.setattr(
        texture, "plate_rig", lambda *_: sensor.rig.model_copy(update={"camera": camera_of(sensor, sweep.quality)})
    )
    lines, plain = (
        texture.press_plate(sensor, each, 1.0, sweep.quality, like=sweep.object, seed=1, untouched=None).contrast
        for each in ("lines", None)
    )
    variance = (lines - plain).var(0).mean()
    assert variance == pytest.approx(lines.var(0).mean() + plain.var(0).mean(), rel=0.05)


def test_camera_reads_out_the_plate_and_little_more():
    sweep = small_sweep("design.footprint_mm=[12,16]", "rig.camera.field_mm=10")
    camera = plate_rig(list_designs(sweep)[0].sensor, 1.4, sweep.quality).camera
    assert (camera.columns, camera.rows) == (48, 64)
    width = camera.region_px[2] * 10 / 48
    assert 7.0 < width < 8.5


def test_pattern_that_the_camera_sees_in_part_is_not_judged():
    sweep = small_sweep("design.footprint_mm=[12,16]", "rig.camera.field_mm=5")
    with pytest.raises(ConfigError, match=r"the camera sees less of the face than 8 mm, 4 spacings"):
        plate_rig(list_designs(sweep)[0].sensor, 2.0, sweep.quality)


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
