import numpy as np
import pytest

from magicsim_experiments.study.mechanics.law_scene import (
    angle_between_deg,
    direction_deg,
    extent_mm,
    moved_places,
    optical_flow_px,
    turn_deg,
)

GRID = np.stack(np.meshgrid(np.linspace(-5, 5, 41), np.linspace(-5, 5, 41)), -1).reshape(-1, 2)


def test_extent_is_the_radius_of_a_disc_that_moved():
    moved = np.where(np.linalg.norm(GRID, axis=1) < 3, 0.2, 0.01)
    assert extent_mm(GRID, moved, least_mm=0.05) == pytest.approx(3, rel=0.02)
    assert extent_mm(GRID, moved, least_mm=0.5) == 0


@pytest.mark.parametrize("angle", [-135.0, 0.0, 30.0, 90.0])
def test_direction_is_that_of_the_sum(angle: float):
    moved = np.exp(-(GRID**2).sum(1))[:, None] * [np.cos(np.radians(angle)), np.sin(np.radians(angle))]
    assert direction_deg(moved) == pytest.approx(angle)
    assert angle_between_deg(direction_deg(moved), angle + 360) == pytest.approx(0, abs=1e-9)


def test_turn_is_that_of_a_small_rotation_and_none_of_a_shift():
    angle = 3.0
    turned = np.radians(angle) * GRID[:, ::-1] * [-1, 1]
    assert turn_deg(GRID, turned) == pytest.approx(angle)
    assert turn_deg(GRID, turned + np.array([0.4, -0.2])) == pytest.approx(angle)


def test_places_that_hardly_moved_do_not_count():
    assert moved_places(np.array([[0.0, 1.0], [0.1, 0.0], [0.0, -0.3]])).tolist() == [True, False, True]


def test_flow_finds_a_shift_of_a_pattern():
    random = np.random.default_rng(0)
    coarse = random.uniform(40, 200, (12, 16))
    picture = np.kron(coarse, np.ones((10, 10)))
    kernel = np.hanning(9)
    for axis in (0, 1):
        picture = np.apply_along_axis(lambda line: np.convolve(line, kernel / kernel.sum(), "same"), axis, picture)
    image = np.repeat(picture[..., None], 3, 2).astype(np.uint8)
    flow = optical_flow_px(image, np.roll(image, (2, 3), (0, 1)))
    assert np.median(flow[30:-30, 30:-30], axis=(0, 1)) == pytest.approx([3, 2], abs=0.3)
