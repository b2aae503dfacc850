"""Rules that leave work out: what they promise is what they keep."""

import json

import numpy as np
import pytest
from laboratory.light.left_out import (
    SMALL,
    LeftOutRow,
    Rule,
    bare_outputs,
    dark_flashlight,
    measured,
    out_of_reach,
    recorded,
    still_meshes,
)
from laboratory.light.plots import plot_left_out
from PIL import Image

FACE = (
    *SMALL, "design.footprint_mm=[8,9]", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
    "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=32", "render.particles=2000",
    "render.anchor_particles=8000",
)  # fmt: skip
"""A part of the face, where the result must be the same to the last bit."""


def test_row_says_what_a_rule_saves_and_changes() -> None:
    row = measured(
        Rule(name="half", result="statistical", full=lambda: np.full(4, 2.0), lean=lambda: np.full(4, 2.1),
             again=(lambda: np.full(4, 2.3), lambda: np.full(4, 1.7))),
        3,
    )  # fmt: skip
    assert isinstance(row, LeftOutRow)
    assert row.difference == pytest.approx(0.05)
    assert row.noise == pytest.approx(np.hypot(0.3, 0.4) / np.sqrt(2) / 2)


@pytest.mark.parametrize("rule", [bare_outputs, still_meshes, dark_flashlight])
def test_exact_rule_changes_nothing(rule) -> None:
    both = rule(FACE)
    np.testing.assert_array_equal(both.lean(), both.full())


def test_far_object_changes_next_to_nothing() -> None:
    assert measured(out_of_reach((*FACE, "object.radius_mm=100")), 1).difference < 1e-3


@pytest.mark.slow
def test_recorded_paths_differ_by_their_noise() -> None:
    row = measured(recorded("near")(SMALL), 1)
    assert 0 < row.difference < 1.5 * row.noise


def test_plot_is_drawn_from_the_file(tmp_path) -> None:
    row = {"rule": "one", "result": "exact", "seconds_full": 2.0, "seconds": 0.5, "difference": 0.0, "noise": None}
    plot_left_out(
        json.loads(json.dumps({"kind": "left-out", "results": [row, row | {"noise": 0.1}]})), tmp_path / "plot.png"
    )
    with Image.open(tmp_path / "plot.png") as plot:
        assert plot.size[0] > 300
