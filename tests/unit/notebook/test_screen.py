"""What a screen shows of frames: sRGB once, and the change against rest, four times amplified, around grey."""

import numpy as np
import pytest

from magicsim.notebook.screen import EDGE_PX, beside_change, change, from_srgb, on_screen, to_srgb


def flat(value: float) -> np.ndarray:
    return np.full((2, 3, 3), value, np.uint8)


@pytest.mark.parametrize(
    ("linear", "coded"), [(0.0, 0.0), (0.001, 0.01292), (0.0031308, 0.04045), (0.2140, 0.5), (0.18, 0.4614), (1.0, 1.0)]
)
def test_srgb_has_its_published_values(linear: float, coded: float):
    assert to_srgb(np.array(linear)) == pytest.approx(coded, abs=1e-4)
    assert from_srgb(np.array(coded)) == pytest.approx(linear, abs=1e-4)


def test_grey_levels_linear_in_light_get_the_curve_of_a_screen():
    # half of white's light is a pixel of 188 in any table of sRGB
    assert on_screen(flat(128), gamma=1.0).tolist() == flat(188).tolist()
    assert [int(on_screen(flat(grey), gamma=1.0)[0, 0, 0]) for grey in (0, 20, 255)] == [0, 79, 255]


@pytest.mark.parametrize("gamma", [2.2, 0.5, None])
def test_a_camera_with_a_tone_curve_is_not_coded_twice(gamma: float | None):
    assert (on_screen(flat(20), gamma=gamma) == flat(20)).all()


def test_change_is_four_times_around_mid_grey_and_rest_is_mid_grey():
    rest = np.random.default_rng(1).integers(0, 256, (4, 5, 3), np.uint8)
    assert (change(rest, rest) == 128).all()
    values = [int(change(flat(grey), flat(60))[0, 0, 0]) for grey in (59, 61, 70, 0, 255)]
    assert values == [124, 132, 168, 0, 255]
    assert (change(flat(60), np.mean([flat(60), flat(61)], axis=0)) == 126).all()


def test_frame_stands_left_of_its_change():
    both = beside_change(flat(61), flat(60), gamma=1.0)
    assert both.shape == (2, 6 + EDGE_PX, 3)
    assert (both[:, :3] == on_screen(flat(61), gamma=1.0)).all()
    assert (both[:, -3:] == 132).all()
    assert (both[:, 3:-3] == 0).all()


def test_without_a_rest_the_frame_stands_alone():
    assert (beside_change(flat(61), None, gamma=2.2) == flat(61)).all()
