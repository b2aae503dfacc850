"""Fields of touch as columns of a dataset."""

import io
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.dataset.columns import columns_of
from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.estimate import taxel_bytes
from magicsim.dataset.rows import SampleTask, simulate_sample
from magicsim.dataset.verify import verify_dataset
from magicsim.workers.attempt import WorkerOptions

from .fakes import FAKE, small_recipe

ASKED = ("labels.taxels.rows=4", "labels.taxels.columns=3")
PRESS = "paths=[{kind='touch',depth_mm=0.6,x_mm=0.5,friction=0.5,shear_mm=0.3,twist_frames=0}]"
CONSTANTS = {"config_hash": "0", "version": "0", "variant": "0"}
TOUCH = ("taxel_", "skin_", "infill_", "max_skin", "max_infill")


def touch_of(*settings: str) -> dict[str, str]:
    return {each.name: each.meaning for each in columns_of(small_recipe(*settings)) if each.name.startswith(TOUCH)}


def test_recipe_has_the_columns_that_it_asks_for_and_no_others():
    assert touch_of() == {}
    whole = touch_of(*ASKED)
    assert list(whole) == [
        "taxel_force_n", "taxel_torque_nmm", "skin_stretch", "max_skin_stretch", "skin_von_mises_mpa",
        "max_skin_von_mises_mpa", "infill_shear", "max_infill_shear",
    ]  # fmt: skip
    assert whole["taxel_force_n"].endswith("4 x 3 taxels over the face, row by row, row 0 at +y [N]")
    some = touch_of(*ASKED, "labels.taxels.unit='MPa'", "labels.taxels.skin=false", "labels.taxels.infill=false")
    assert list(some) == ["taxel_traction_mpa", "taxel_torque_nmm"]


def test_fields_cost_disk_only_where_they_are_asked_for():
    assert taxel_bytes(draw_episodes(small_recipe())[0].scene) == 0
    assert taxel_bytes(draw_episodes(small_recipe(*ASKED))[0].scene) == 4 * 3 * 8 * 9


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("unit", ["N", "MPa"])
def test_verify_finds_taxels_that_do_not_add_up(tmp_path: Path, unit: str):
    recipe, options = small_recipe("episodes=2", *ASKED, f"labels.taxels.unit={unit}"), WorkerOptions(workers=1)
    generate_dataset(recipe, tmp_path / "set", options=options, simulator=FAKE)  # random numbers, no force
    found = verify_dataset(tmp_path / "set").problems
    assert any("taxel_force_n does not add up to force_n" in each for each in found) == (unit == "N")
    assert any("taxel_torque_nmm does not add up to torque_nmm" in each for each in found)


@pytest.mark.slow
def test_taxels_of_an_episode_add_up_to_its_forces():
    recipe = small_recipe(PRESS, *ASKED)
    task = SampleTask(episode=draw_episodes(recipe)[0], columns=columns_of(recipe), constants=CONSTANTS)
    rows = pq.read_table(io.BytesIO(simulate_sample(task))).to_pylist()
    assert any(row["contact"] for row in rows)
    for row in rows:
        np.testing.assert_allclose(np.sum(row["taxel_force_n"], 0), row["force_n"], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(np.sum(row["taxel_torque_nmm"], 0), row["torque_nmm"], rtol=1e-9, atol=1e-9)
        assert (row["max_skin_stretch"] > 1.01) == row["contact"]
        assert (row["max_infill_shear"] > 0) == row["contact"]
