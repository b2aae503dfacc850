"""Rows of the study from fields that are known; the solver and the renderer have tests of their own."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.study.mechanics.deformation_law import (
    DeformationLaw,
    press_rows,
    shear_rows,
    spread,
    twist_rows,
)
from magicsim_experiments.study.mechanics.law_scene import Touch
from magicsim_experiments.study.study_file import load_study

AXIS = np.linspace(-4, 4, 17)
PLACES = np.stack(np.meshgrid(AXIS, AXIS), -1).reshape(-1, 2)
LANDING = np.stack(np.meshgrid(np.linspace(-4, 4, 65), np.linspace(4, -4, 65)), -1)


def fields(*moved: np.ndarray) -> dict[str, np.ndarray]:
    """Touches that move the grid after a press that did not, in an image that shows nothing of it."""
    count = len(moved)
    image = np.full((count, 65, 65, 3), 90, np.uint8)
    flat = np.zeros((count, len(PLACES), 3))
    mask = np.repeat(np.linalg.norm(LANDING, axis=-1)[None] < 1.5, count, 0)
    flat[..., :2] = moved
    return {
        "places_mm": PLACES, "untouched": image[0], "pressed_mm": np.zeros_like(flat), "moved_mm": flat,
        "pressed_image": image, "image": image, "mask": mask,
        "force_n": np.tile([0.1, 0.0, 2.0], (count, 1)), "torque_nmm": np.tile([0.0, 0.0, 0.5], (count, 1)),
    }  # fmt: skip


def test_keyframes_press_do_what_follows_and_lift():
    assert [pose["gap_mm"] for pose in Touch(depth_mm=0.5).keyframes()] == [-0.5, 1.0]
    press, sheared, lifted = Touch(depth_mm=0.5, shear_mm=0.4, direction_deg=90).keyframes()
    assert (press["x_mm"], press["y_mm"]) == (0, 0)
    assert (sheared["x_mm"], sheared["y_mm"]) == pytest.approx((0, 0.4))
    assert lifted["gap_mm"] == 1.0


def test_shear_of_the_grid_is_seen_in_its_direction():
    near = np.exp(-(PLACES**2).sum(1) / 2)[:, None]
    rows = list(shear_rows(fields(near * [0.2, 0.0], near * [0.0, -0.2]), (0.0, 270.0), LANDING))
    assert [row["grid_error_deg"] for row in rows] == pytest.approx([0, 0], abs=1e-9)
    assert rows[0]["grid_mm"] == pytest.approx(rows[1]["grid_mm"])


def test_twist_of_the_grid_has_its_sense():
    turned = np.radians(5.0) * PLACES[:, ::-1] * [-1, 1]
    rows = list(twist_rows(fields(turned, -turned), (20.0, 20.0), LANDING))
    assert rows[0]["grid_turn_deg"] == pytest.approx(5, rel=0.05)
    assert [row["grid_sense"] for row in rows] == [True, False]


def test_press_has_size_and_extent():
    moved = np.where(np.linalg.norm(PLACES, axis=1) < 2, 0.3, 0.0)[:, None] * [1.0, 0.0]
    (row,) = press_rows(fields(moved), (0.5,))
    assert row["grid_mm"] == pytest.approx(0.3)
    assert row["grid_extent_mm"] == pytest.approx(2, rel=0.1)
    assert row["fz_n"] == 2.0


def test_spread_is_relative_to_the_mean():
    assert spread([1.0, 1.0]) == 0
    assert spread([0.9, 1.1]) == pytest.approx(0.2)


def test_design_without_a_grid_and_too_deep_presses_are_refused_in_a_line():
    with pytest.raises(ConfigError, match=r"needs a printed grid: design.cell_mm = 0"):
        load_study("deformation-law", design="uniform-block")
    with pytest.raises(ConfigError, match=r"depths_mm = 8 is not allowed: at most 5.94"):
        load_study("deformation-law", ["depths_mm=[0.5,8.0]"])
    study = load_study("deformation-law", quick=True)
    assert isinstance(study, DeformationLaw)
    assert [len(task.touches) for task in study.touches.tasks] == [3, 4, 2]
    assert study.rig.camera.rows * 2 == study.config.rig.camera.rows
