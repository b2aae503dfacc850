"""Surfaces of known units, and the study from presses that follow Hertz; the solver has tests of its own."""

import json
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.study.mechanics.manufacturing import (
    Manufacturing,
    TouchCurve,
    UnitTolerances,
    drawn_unit,
    touch_curve,
)
from magicsim_experiments.study.mechanics.surfaces import (
    UnitShape,
    depth_at,
    fitted_surface,
    outliers,
    touched_heights_mm,
)
from magicsim_experiments.study.study_file import load_study

RANDOM = np.random.default_rng(3)
PLACES = RANDOM.uniform(-10, 10, (400, 2))
FLAT = {"wave_mm": 0.0, "wave_length_mm": 12.0, "wave_phases": (0.0, 0.0, 0.0, 0.0), "stiffness": 1.0}


def study(*settings: str) -> Manufacturing:
    found = load_study("manufacturing", ["draws=2", *settings], quick=True)
    assert isinstance(found, Manufacturing)
    return found


def hertz_pieces(folder: Path, found: Manufacturing, *, stiffness: float = 2.0) -> None:
    """Forces stiffness depth^1.5 as if every press had been solved."""
    place = folder / "pieces" / "touches"
    place.mkdir(parents=True)
    for number, task in enumerate(found.touches.tasks):
        assert isinstance(task, TouchCurve)
        force = [stiffness * depth**1.5 for depth in task.depths_mm]
        (place / f"{number:05d}.json").write_text(json.dumps(force))


def test_tilted_unit_is_found_where_it_is():
    unit = UnitShape(height_mm=0.1, slope=(0.01, -0.02), **FLAT)
    depth = np.full(len(PLACES), 0.2)
    heights = touched_heights_mm(unit, PLACES, depth, RANDOM, repeat_sd_mm=0.0, step_mm=0.001)
    surface = fitted_surface(PLACES, heights)
    corners = np.array([[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0]])
    np.testing.assert_allclose(surface(corners), 0.1 - 0.2 + corners @ [0.01, -0.02], atol=2e-3)


def test_touch_that_is_far_off_is_left_out():
    heights = RANDOM.normal(0, 0.01, len(PLACES))
    heights[7] = 1.0
    assert outliers(PLACES, heights)[7]
    assert outliers(PLACES, heights).mean() < 0.1
    assert abs(fitted_surface(PLACES, heights)(PLACES[7:8])[0]) < 0.02


def test_depth_at_a_force_is_exact_for_hertz():
    depths = np.array([0.2, 0.4, 0.6])
    assert depth_at(2 * 0.3**1.5, depths, 2 * depths**1.5) == pytest.approx(0.3)
    assert depth_at(2 * 0.05**1.5, depths, 2 * depths**1.5) == pytest.approx(0.05)


def test_units_without_tolerances_are_one_surface():
    unit = drawn_unit(UnitTolerances(thickness_sd_mm=0, slope_sd_deg=0, wave_sd_mm=0, stiffness_sd=0), RANDOM)
    assert unit.stiffness == 1
    assert not unit.rise_mm(PLACES).any()


def test_units_differ_by_their_tolerances_and_repeat_by_the_probe(tmp_path: Path):
    found = study()
    hertz_pieces(tmp_path, found)
    result = found.conclude(tmp_path)
    printed, moulded = (dict(row) for row in result.tables[0].rows)
    assert moulded["between_units_mm"] > 4 * printed["between_units_mm"] > 8 * printed["self_repeat_mm"]
    assert printed["self_repeat_mm"] < found.config.probe.repeat_sd_mm
    assert printed["depth_at_threshold_mm"] == pytest.approx((0.05 / 2) ** (2 / 3))
    assert [len(table.rows) for table in result.tables] == [2, 6, 6]
    again = found.conclude(tmp_path)
    assert again.tables[0].rows == result.tables[0].rows


def test_presses_that_do_not_reach_the_threshold_are_told(tmp_path: Path):
    found = study("probe.threshold_n=5.0")
    hertz_pieces(tmp_path, found)
    with pytest.raises(ConfigError, match=r"depths_mm = 0.6 at most is too little.*probe.threshold_n = 5"):
        found.conclude(tmp_path)


def test_moulded_gel_has_the_footprint_of_the_design_and_no_grid():
    found = study()
    assert found.designs["moulded"].footprint_mm == found.designs["printed"].footprint_mm
    assert not found.designs["moulded"].has_grid
    assert len(found.touches.tasks) == 2 * (4 + 1)


def test_press_is_solved_where_it_is_asked_for():
    found = study("design.footprint_mm=[10,10]", "design.lattice.spacing_mm=2.0", "depths_mm=[0.1,0.2]")
    force = json.loads(touch_curve(found.touches.tasks[0]))
    assert 0 < force[0] < force[1]
