from dataclasses import replace

import numpy as np
import pytest
from laboratory.operating_point.filming import GAPS_MM, Approach, FilmedStates
from laboratory.operating_point.reading import (
    MARGIN,
    crosstalk_matrix,
    disparity,
    evenness,
    lead_mm,
    read_states,
    scaled,
    settled_gain,
    short_of,
)
from laboratory.operating_point.search import CAMERA_NAMES, EFFECT_NAMES, LEFT_OUT, effects

from magicsim.camera.camera import Camera
from magicsim.camera.effect_settings import LiveExposure
from magicsim.camera.exposure import meter
from magicsim.detectors import load_profile

CAMERA = Camera(columns=48, rows=64)


def states() -> FilmedStates:
    """Dark lines on a bright ground; objects brighten one colour each in a place of its own, a flashlight all alike."""
    row, column = np.indices((64, 48))
    lines = np.where((row % 8 < 2) | (column % 8 < 2), 0.15, 1.0)
    rest = np.stack([lines] * 3, -1).astype(np.float32)
    places = np.stack([column / 48, 1 - column / 48, row / 64], -1)
    near = [rest + (places / (1 + gap)).astype(np.float32) for gap in GAPS_MM]
    light = np.repeat((0.2 + row / 64)[..., None], 3, axis=2).astype(np.float32)
    touch = np.where(row[..., None] > 32, 1.0, rest).astype(np.float32)
    strips = Approach(rest=rest, near=np.stack(near), touch=np.stack([touch, touch]))
    # A room that is seen as white between the lines, and that the object takes away.
    room = Approach(rest=rest, near=np.stack([rest * 0.5] * len(GAPS_MM)), touch=np.zeros((2, 64, 48, 3), np.float32))
    return FilmedStates(strips=strips, room=room, light=light)


def read(camera: Camera = CAMERA, **changes: float):
    options = {"ambient": 0.0, "flashlight": 1.0, "crosstalk": 0.0} | changes
    return read_states(states(), camera, profile=replace(load_profile("published"), grid_blur_px=0), **options)


def test_quantities_of_a_plain_sensor():
    found = read().quantities
    assert found["s_rest"] == pytest.approx(1, abs=0.01)
    assert found["s_touch"] == pytest.approx(0.5, abs=0.05)
    assert found["c_light"] == pytest.approx(1, abs=0.02)
    assert found["c_near"] < 0
    assert found["e_near"] > 4 > found["e_rest"]
    assert found["lead_mm"] == max(GAPS_MM)


def test_right_verdicts_are_those_of_the_published_thresholds():
    found, profile = read(), load_profile("published")
    low = np.array(found.similarity) < profile.tau_g
    alike = (np.array(found.entropy) >= profile.tau_e) & (np.array(found.correlation) >= profile.tau_c)
    touched, count = low & ~alike, len(GAPS_MM)
    assert found.right["touched"] == touched[count:].mean() == 0  # brightens alike, so that it may be light
    assert found.right["untouched"] == 1 - touched[:count].sum() / (count + 2) == 0.75
    assert found.right["near"] == found.right["light"] == 1
    assert read(flashlight=0.0).right["light"] == 0


def test_a_sensor_is_short_of_right_verdicts_by_what_lies_on_the_wrong_side():
    profile, count = load_profile("published"), len(GAPS_MM)
    far, near = [0.9] * count, [0.4, 0.3]
    values = {"similarity": far + near, "entropy": [3.0] * (count + 2), "correlation": [0.0] * (count + 2)}
    right = replace(read(), quantities={"c_light": 0.9, "e_rest": 0.1}, **values)
    assert short_of(right, profile) == 0
    blind = replace(right, similarity=[*far, 0.4, profile.tau_g + 0.1])
    assert short_of(blind, profile) == pytest.approx((1 + MARGIN) / 2)
    alike = replace(right, quantities={"c_light": profile.tau_c, "e_rest": profile.tau_e})
    assert short_of(alike, profile) == pytest.approx(2 * MARGIN)


def test_crosstalk_makes_the_colours_alike_and_the_flashlight_moves_what_it_lights_alone():
    assert read(crosstalk=0.3).quantities["c_near"] > read().quantities["c_near"] + 0.1
    weak, strong = read(flashlight=0.05), read(flashlight=1.0)
    assert weak.quantities["s_light"] > strong.quantities["s_light"]
    assert weak.quantities["s_touch"] == strong.quantities["s_touch"]


def test_room_that_is_covered_leaves_the_dark_grid_dark_and_live_exposure_lifts_it():
    locked, live = read(ambient=2.0), read(CAMERA.model_copy(update={"live": LiveExposure()}), ambient=2.0)
    assert locked.quantities["s_near"] > read().quantities["s_near"] + 0.3
    assert live.quantities["s_near"] < locked.quantities["s_near"] - 0.03


def test_settled_gain_brings_a_state_back_to_the_aim_and_to_balance():
    camera = CAMERA.model_copy(update={"live": LiveExposure(), "exposure_grey": 60.0})
    bright, dim = states().strips.rest, (states().strips.rest * np.array([0.4, 0.5, 0.9])).astype(np.float32)
    gain = settled_gain(dim, camera, meter(bright, camera))
    np.testing.assert_allclose((dim * gain).mean((0, 1)), 60 / 255, rtol=1e-3)


def test_colour_matrix_keeps_white():
    assert np.sum(crosstalk_matrix(0.2), axis=1) == pytest.approx(1)
    assert crosstalk_matrix(0.0) == ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def test_lead_counts_back_from_contact():
    seen = [True] * len(GAPS_MM)
    assert lead_mm(seen) == GAPS_MM[0]
    seen[1] = False
    assert lead_mm(seen) == GAPS_MM[2]
    assert lead_mm([*seen[:-1], False]) == 0


def test_evenness_and_disparity_tell_one_sided_light_from_even_light():
    _, column = np.indices((64, 48))
    even = np.ones((64, 48, 3))
    sided = np.stack([1 + column, 48 - column, np.full((64, 48), 20)], -1).astype(float)
    assert evenness(even) == [1, 1, 1]
    assert disparity(even) == 0
    red, _, blue = evenness(sided)
    assert red < 0.2
    assert blue == 1
    assert disparity(sided) > 0.3
    assert disparity(np.repeat(sided[..., :1], 3, axis=2)) == pytest.approx(0, abs=1e-12)


def test_blur_of_a_smaller_image_covers_the_same_part_of_the_face():
    profile = load_profile("published")
    assert [scaled(profile, columns=size, full=240).grid_blur_px for size in (240, 120, 60)] == [5, 3, 1]


def test_every_effect_of_the_camera_changes_what_is_read_and_nothing_where_it_is_off():
    lit = {"ambient": 0.5}
    plain = read(CAMERA, **lit)
    off = [0.0] * len(CAMERA_NAMES)
    assert effects(off, CAMERA) == {"vibration_px": 0.0, "compression": None}
    assert read(CAMERA.model_copy(update=effects(off, CAMERA)), **lit) == plain
    for name in EFFECT_NAMES:
        on = [1.0 if each == name else 0.0 for each in CAMERA_NAMES]
        found = read(CAMERA.model_copy(update=effects(on, CAMERA)), **lit)
        assert found.quantities != plain.quantities, name
        assert any(set(change) == {name} and change[name] == 0 for change in LEFT_OUT.values()), name


def test_frames_that_shake_show_entropy_at_rest():
    on = [1.0 if each == "vibration" else 0.0 for each in CAMERA_NAMES]
    found = read(CAMERA.model_copy(update=effects(on, CAMERA)), ambient=0.5)
    assert found.quantities["e_rest"] > read(ambient=0.5).quantities["e_rest"]


def test_effects_keep_their_part_of_the_field_in_another_image():
    full = CAMERA.model_copy(update={"columns": 240, "rows": 320})
    half = CAMERA.model_copy(update={"columns": 120, "rows": 160})
    on = [0.5] * len(CAMERA_NAMES)
    large, small = effects(on, full), effects(on, half)
    assert large["vibration_px"] == 2 * small["vibration_px"] > 0
    assert large["glare"].radius_px == 2 * small["glare"].radius_px
    assert large["flicker"] == small["flicker"]
