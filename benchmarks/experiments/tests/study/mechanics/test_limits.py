import json
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim_experiments.study.mechanics.limits import Limits, first_passed, flow_rows
from magicsim_experiments.study.study_file import load_study

SMALL = (
    "diameters_mm=[4.0]", "skins_mm=[0.5]", "depths_mm=[0.5,1.0]", "cells.depths_mm=[0.5,1.0]", "beside.skins_mm=[]",
    "sheared.paths_mm=[[1.2,1.0]]", "infill_yield.low_mpa=0.00471", "infill_yield.mpa=0.00942",
)  # fmt: skip


def small(*more: str) -> Limits:
    study = load_study("limits", [*SMALL, *more])
    assert isinstance(study, Limits)
    return study


def row(depth: float, **values: float | str | None) -> dict[str, float | str | None]:
    return {"diameter_mm": 4.0, "skin_mm": 0.5, "depth_mm": depth, "refused": None, **values}


PRESSES = [row(0.5, fz_n=0.5, skin_stretch=1.1, skin_von_mises_mpa=0.2),
           row(1.0, fz_n=1.5, skin_stretch=1.3, skin_von_mises_mpa=0.6)]  # fmt: skip
CELLS = [row(0.5, fz_n=0.6, least_infill_shear=0.2, most_infill_shear=0.3),
         row(1.0, fz_n=1.6, least_infill_shear=0.4, most_infill_shear=0.6)]  # fmt: skip


def test_level_is_first_passed_between_two_places():
    assert first_passed(np.array([0.0, 1.0, 3.0]), 2.0) == 1.5
    assert first_passed(np.array([0.0, 1.0, 0.5, 3.0]), 0.75) == 0.75
    assert first_passed(np.array([0.0, 1.0]), 2.0) is None


def test_infill_flows_where_its_least_shear_passes_the_yield_strain():
    """A yield stress of 0.3 moduli: half-way between the depths, with force and skin of there."""
    low, middle, _ = flow_rows(PRESSES, CELLS, small().config)
    assert low["depth_mm"] == pytest.approx(0.75)
    assert low["fz_n"] == pytest.approx(1.1)
    assert low["skin_stretch"] == pytest.approx(1.2)
    assert low["skin_von_mises_mpa"] == pytest.approx(0.4)
    assert "depth_mm" not in middle
    assert middle["deepest_mm"] == 1.0


def test_result_keeps_presses_that_do_not_converge_with_their_reason(tmp_path: Path):
    study = small()
    refused = {"diameter_mm": 4.0, "skin_mm": 0.5, "depth_mm": 1.0, "refused": "no equilibrium, residual 3e-4"}
    pieces = {"presses": [PRESSES[0], refused], "cells": CELLS}
    for name, rows in pieces.items():
        (tmp_path / "pieces" / name).mkdir(parents=True)
        (tmp_path / "pieces" / name / "00000.json").write_text(json.dumps(rows))
    (tmp_path / "pieces" / "sheared").mkdir()
    (tmp_path / "pieces" / "sheared" / "00000.refused.json").write_text('{"message": "too thin"}')
    found = study.conclude(tmp_path)
    tables = {table.name: table.rows for table in found.tables}
    assert set(tables) == {"presses", "cells", "flow", "sheared"}
    assert tables["presses"][1]["fz_n"] is None
    assert tables["presses"][1]["refused"] == "no equilibrium, residual 3e-4"
    assert tables["sheared"][0]["refused"] == "too thin"
    assert found.headline == {
        "most_fz_n": 0.5, "most_skin_stretch": 1.1, "most_skin_von_mises_mpa": 0.2, "refused": 2,
    }  # fmt: skip


def test_design_without_a_grid_has_presses_alone():
    study = load_study("limits", [], design="uniform-block")
    assert [len(stage.tasks) for stage in study.stages()] == [6, 0, 0, 2]


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        ("depths_mm=[1.0,0.5]", r"depths_mm = \[1.0, 0.5\] is not allowed: must increase"),
        ("depths_mm=[0.5,6.0]", r"depths_mm = 6 is not allowed: at most 5.4"),
        ("infill_yield.low_mpa=0.1", "must not decrease"),
        ('design.face={kind="dome",radius_x_mm=20,crown_mm=1.0}', "study 'limits' needs a flat face"),
    ],
)
def test_what_cannot_be_done_is_one_line(setting: str, line: str):
    with pytest.raises(ConfigError, match=line) as caught:
        small(setting)
    assert "\n" not in str(caught.value)
