"""Real episodes, small: what their rows say is true, and does not depend on who made them."""

import io
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.spatial import cKDTree

from magicsim.camera.projection import pixel_landing_mm
from magicsim.dataset.columns import columns_of
from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.recipes.draw import draw_episodes, draw_sensors
from magicsim.dataset.rows import SampleTask, simulate_sample
from magicsim.dataset.verify import verify_dataset
from magicsim.geometry.objects.plain import SphereObject
from magicsim.light.records.untouched import shared_states
from magicsim.workers.attempt import WorkerOptions

from .fakes import FOLDER, SMALL, content, decoded, small_recipe

pytestmark = pytest.mark.slow
CONSTANTS = {"config_hash": "0", "version": "0", "variant": "0"}


@pytest.fixture(scope="module")
def recipe():
    return small_recipe("paths=[{kind='touch',depth_mm=0.8,x_mm=0.5,friction=0.5,shear_mm=0.3,twist_frames=0}]")


@pytest.fixture(scope="module")
def rows(recipe) -> list[dict[str, object]]:
    task = SampleTask(episode=draw_episodes(recipe)[0], columns=columns_of(recipe), constants=CONSTANTS)
    return pq.read_table(io.BytesIO(simulate_sample(task))).to_pylist()


def test_forces_balance_and_stand_where_the_object_touches(rows):
    pressed = [row for row in rows if row["contact"]]
    assert len(pressed) >= 6
    for row in pressed:
        assert row["force_balance"] < 1e-6
        assert row["force_n"][2] > 0.1
        assert row["contact_area_mm2"] > 0
        # The torque about the origin of a force at the place of contact, which is on the face below the object.
        x, y, _ = row["object_position_mm"]
        assert row["torque_nmm"][0] / row["force_n"][2] == pytest.approx(y, abs=0.4)
        assert -row["torque_nmm"][1] / row["force_n"][2] == pytest.approx(x, abs=0.4)
    for row in rows:
        if not row["contact"]:
            assert row["force_n"] == [0, 0, 0]
            assert not decoded(row["contact_mask"]).any()


def test_friction_drags_the_skin_along(rows):
    sheared = [row for row in rows if row["contact"] and row["object_position_mm"][0] > 0.7]
    assert sheared
    for row in sheared:
        assert row["force_n"][0] > 0.02
        assert np.hypot(*row["force_n"][:2]) <= 0.5 * row["force_n"][2] * 1.001


def test_mask_lies_where_the_ball_is_below_the_depth_map(recipe, rows):
    sensor = draw_sensors(recipe, 1)[0]
    landing = pixel_landing_mm(sensor.design, sensor.rig.lens, sensor.rig.camera)
    for row in (row for row in rows if row["contact"]):
        mask = decoded(row["contact_mask"]) > 0
        depth = np.array(row["depth_map_mm"])
        x, y, z = row["object_position_mm"]
        ball = SphereObject.model_validate(json.loads(row["object_config"]))
        reach = np.hypot(*(landing[mask] - [x, y]).T)
        assert mask.any()
        # Touched pixels lie on the ball: its surface is as high there as the face.
        surface = z + np.sqrt(ball.radius_mm**2 - np.minimum(reach, ball.radius_mm) ** 2)
        assert np.abs(surface - depth[mask]).max() < 0.12
        assert depth.max() == pytest.approx(row["depth_mm"], abs=0.08)
        assert depth[~mask].max() <= depth[mask].max()


def test_displacements_are_those_of_the_lattice_in_the_sensors_table(recipe, rows):
    from magicsim.deform.lattice.structure import build_lattice

    nodes = build_lattice(draw_sensors(recipe, 1)[0].design).nodes_mm
    top = nodes[:, 2] > nodes[:, 2].max() - 1e-9
    face = nodes[:, 2] < 1e-9
    for row in rows:
        moved = np.array(row["displacements_mm"])
        assert moved.shape == nodes.shape
        assert not moved[top].any()
        assert moved.any() == row["contact"]
        if row["contact"]:
            x, y, _ = row["object_position_mm"]
            _, nearest = cKDTree(nodes[face][:, :2]).query([x, y])
            assert moved[face][nearest, 2] == pytest.approx(row["depth_mm"], abs=0.25)


def test_press_ends_at_the_force_that_was_drawn():
    recipe = small_recipe(
        "paths=[{kind='touch',force_n={low=0.3,high=1.5},friction=0.5,shear_frames=0,twist_frames=0}]"
    )
    episode = draw_episodes(recipe)[0]
    task = SampleTask(episode=episode, columns=columns_of(recipe), constants=CONSTANTS)
    found = pq.read_table(io.BytesIO(simulate_sample(task))).to_pylist()
    deepest = max(found, key=lambda row: row["depth_mm"])
    assert deepest["force_n"][2] == pytest.approx(episode.force_n, rel=0.05)
    assert deepest["drawn.path.force_n"] == episode.force_n
    assert deepest["depth_mm"] < recipe.design.limits.depth_mm
    assert not any(row["beyond_limits"] for row in found)
    assert all(row["in_view"] for row in found)


def test_flashlight_brightens_the_frame():
    recipe = small_recipe("paths=[{kind='flashlight',strength=2.0,lit_frames=2}]")
    task = SampleTask(episode=draw_episodes(recipe)[0], columns=columns_of(recipe), constants=CONSTANTS)
    found = pq.read_table(io.BytesIO(simulate_sample(task))).to_pylist()
    dark, lit = (
        np.mean([decoded(row["image"]).mean() for row in found if row["flashlight"] is on]) for on in (False, True)
    )
    assert lit > dark + 5


def test_rows_do_not_depend_on_the_episodes_before(recipe, rows):
    episodes = draw_episodes(recipe)
    task, other = (
        SampleTask(episode=each, columns=columns_of(recipe), constants=CONSTANTS) for each in episodes[1::-1]
    )
    assert episodes[0].sensor == episodes[1].sensor
    shared_states.cache_clear()
    fresh = simulate_sample(task)
    shared_states.cache_clear()
    simulate_sample(other)
    assert simulate_sample(task) == fresh


def test_dataset_is_the_same_with_one_and_two_processes(tmp_path: Path):
    for workers in (1, 2):
        options = WorkerOptions(workers=workers, max_tasks=2)
        summary = generate_dataset(small_recipe(), tmp_path / str(workers), options=options)
        assert (summary.samples, summary.failed) == (27, 0)
        assert not verify_dataset(tmp_path / str(workers)).problems
    assert content(tmp_path / "1") == content(tmp_path / "2")


def test_real_run_that_was_killed_ends_as_if_it_had_not_been(tmp_path: Path):
    generate_dataset(small_recipe(), tmp_path / "whole", options=WorkerOptions(workers=1))
    settings = [part for each in SMALL for part in ("--set", each)]
    command = [sys.executable, "-m", "magicsim", "dataset", str(FOLDER / "small.toml"), "--out", str(tmp_path / "set")]
    run = subprocess.Popen(
        [*command, "--workers", "2", *settings], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL
    )
    while not list((tmp_path / "set").rglob("*.parquet"))[1:]:
        assert run.poll() is None
        time.sleep(0.2)
    run.kill()
    run.wait()
    assert not [each for each in verify_dataset(tmp_path / "set").problems if "yet" not in each]
    generate_dataset(small_recipe(), tmp_path / "set", options=WorkerOptions(workers=2), resume=True)
    assert content(tmp_path / "set") == content(tmp_path / "whole")
