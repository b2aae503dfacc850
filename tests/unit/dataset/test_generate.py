import io
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest

from magicsim.config.program import versions
from magicsim.dataset.columns import columns_of
from magicsim.dataset.generate import generate_dataset
from magicsim.dataset.manifest import MANIFEST, read_manifest
from magicsim.dataset.recipes.draw import draw_episodes, draw_sensors
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.dataset.rows import sensors_table
from magicsim.dataset.verify import verify_dataset
from magicsim.deform.indentation.force import Reached
from magicsim.deform.lattice.structure import build_lattice
from magicsim.errors import ConfigError, OutputError
from magicsim.folder.ledger import Ledger
from magicsim.folder.listing import sealed
from magicsim.workers.attempt import WorkerOptions

from . import fakes
from .fakes import FAILING, FAKE, content, small_recipe

ONE, TWO = WorkerOptions(workers=1), WorkerOptions(workers=2, max_tasks=5)


def test_dataset_has_a_row_for_every_frame_and_nothing_left_over(whole: Path):
    manifest = read_manifest(whole)
    rows = {entry.file: pq.read_table(whole / entry.file, columns=["episode"]).num_rows for entry in manifest.shards}
    assert {entry.file: entry.rows for entry in manifest.shards} == rows
    assert sorted(episode for entry in manifest.shards for episode in entry.episodes) == list(range(11))
    assert manifest.is_complete
    assert {path.name for path in whole.iterdir()} == {
        "README.md", "calibration.json", "config.toml", "data", "manifest.json", "sensors.parquet",
    }  # fmt: skip
    assert not verify_dataset(whole).problems


def test_row_groups_stay_small(whole: Path):
    for path in (whole / "data").glob("*.parquet"):
        metadata = pq.read_metadata(path)
        assert max(metadata.row_group(number).num_rows for number in range(metadata.num_row_groups)) <= 100


def test_content_does_not_depend_on_the_number_of_processes(whole: Path, tmp_path: Path):
    generate_dataset(small_recipe("episodes=11"), tmp_path / "set", options=TWO, simulator=FAKE)
    assert content(tmp_path / "set") == content(whole)


@pytest.mark.usefixtures("in_process")
def test_dataset_that_has_grown_is_the_one_that_was_made_at_once(whole: Path, tmp_path: Path):
    for episodes in (1, 4, 11):
        recipe = small_recipe(f"episodes={episodes}")
        generate_dataset(recipe, tmp_path / "set", options=ONE, simulator=FAKE, resume=True)
        assert not verify_dataset(tmp_path / "set").problems
    assert content(tmp_path / "set") == content(whole)


def test_written_recipe_makes_the_same_dataset(whole: Path, tmp_path: Path):
    recipe = fakes.load_recipe(whole / "config.toml")
    assert recipe.config_hash() == small_recipe().config_hash()
    assert recipe.episodes == 11


@pytest.mark.usefixtures("in_process")
def test_episode_without_an_answer_is_left_out_and_logged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("FAKE_CRASH", str(tmp_path / "never"))
    out = tmp_path / "set"
    summary = generate_dataset(small_recipe(), out, options=ONE, simulator=FAILING)
    assert summary.failed == 1
    manifest = read_manifest(out)
    assert [(each.episode, each.kind) for each in manifest.failed] == [(1, "refused")]
    assert manifest.is_complete
    assert 1 not in {episode for entry in manifest.shards for episode in entry.episodes}
    line = json.loads((out / "errors.jsonl").read_text())
    assert (line["episode"], line["message"]) == (1, "the deformation did not reach a valid equilibrium")
    assert not verify_dataset(out).problems


@pytest.mark.slow
def test_lost_episode_is_made_up_for_on_resuming(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    crash = tmp_path / "crash"
    monkeypatch.setenv("FAKE_CRASH", str(crash))
    out, recipe = tmp_path / "set", small_recipe()
    crash.touch()
    summary = generate_dataset(recipe, out, options=ONE, simulator=FAILING)
    assert summary.failed == 2
    assert [(each.episode, each.kind) for each in read_manifest(out).failed] == [(1, "refused"), (2, "crash")]
    log = [json.loads(line) for line in (out / "errors.jsonl").read_text().splitlines()]
    assert [(line["episode"], line["kind"]) for line in log].count((2, "crash")) == 3
    assert "ConvergenceError" in next(line["traceback"] for line in log if line["episode"] == 1)
    crash.unlink()
    again = generate_dataset(recipe, out, options=ONE, simulator=FAILING, resume=True)
    assert again.failed == 1
    at_once = tmp_path / "at-once"
    generate_dataset(recipe, at_once, options=ONE, simulator=FAILING)
    assert content(out) == content(at_once)


@pytest.mark.parametrize(
    ("settings", "seed", "named"),
    [
        (["episodes=3"], None, "episodes = 3 is not allowed"),
        (["references=2"], None, "another recipe"),
        ([], 4, "another recipe"),
    ],
)
def test_resuming_refuses_another_dataset(whole: Path, settings: list[str], seed: int | None, named: str):
    before = content(whole)
    with pytest.raises(OutputError, match=named):
        generate_dataset(small_recipe(*settings, seed=seed), whole, options=ONE, simulator=FAKE, resume=True)
    assert content(whole) == before


def test_folder_with_a_dataset_or_other_files_is_refused(whole: Path, tmp_path: Path):
    with pytest.raises(OutputError, match="holds a dataset already; --resume goes on"):
        generate_dataset(small_recipe("episodes=11"), whole, options=ONE, simulator=FAKE)
    (tmp_path / "notes.txt").touch()
    with pytest.raises(OutputError, match="holds other files"):
        generate_dataset(small_recipe(), tmp_path, options=ONE, simulator=FAKE, resume=True)
    with pytest.raises(OutputError, match="is a file"):
        generate_dataset(small_recipe(), tmp_path / "notes.txt", options=ONE, simulator=FAKE)


@pytest.mark.usefixtures("in_process")
def test_shard_that_was_damaged_is_made_again(whole: Path, tmp_path: Path):
    out = tmp_path / "set"
    recipe = small_recipe("episodes=11")
    generate_dataset(recipe, out, options=ONE, simulator=FAKE)
    shard = sorted((out / "data").glob("*.parquet"))[1]
    damaged = bytearray(shard.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    shard.write_bytes(damaged)
    assert [problem.split(":")[0] for problem in verify_dataset(out).problems] == [f"data/{shard.name}"]
    generate_dataset(recipe, out, options=ONE, simulator=FAKE, resume=True)
    assert content(out) == content(whole)


@pytest.mark.usefixtures("in_process")
def test_full_disk_is_one_line_and_what_is_finished_is_kept(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    out, recipe = tmp_path / "set", small_recipe("episodes=11")
    placed = []

    def write_until_full(path: Path, *rest: object) -> int:
        if len(placed) == 2:
            path.write_bytes(b"half")
            raise OSError(28, "No space left on device")
        placed.append(path)
        return real(path, *rest)

    real = sys.modules["magicsim.dataset.assembly"].write_rows
    with monkeypatch.context() as patch:
        patch.setattr("magicsim.dataset.assembly.write_rows", write_until_full)
        with pytest.raises(OutputError, match=r"cannot write .*no space left on the disk; what is finished is kept"):
            generate_dataset(recipe, out, options=ONE, simulator=FAKE)
    found = verify_dataset(out)
    assert (found.shards, found.complete, found.problems) == (2, False, [])
    generate_dataset(recipe, out, options=ONE, simulator=FAKE, resume=True)
    assert content(out) == content(whole)


def test_target_that_cannot_be_written_is_one_line(tmp_path: Path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"cannot write .*file.set: "):
        generate_dataset(small_recipe(), tmp_path / "file" / "set", options=ONE, simulator=FAKE)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_target_is_one_line(tmp_path: Path):
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="cannot write"):
        generate_dataset(small_recipe(), tmp_path / "set", options=ONE, simulator=FAKE)
    tmp_path.chmod(0o700)


def kill_at_random(out: Path, seed: int, times: int, *, workers: bool) -> None:
    """Starts a run again and again and kills it, or one of its processes, at a random moment."""
    chance = random.Random(seed)
    environment = {**os.environ, "FAKE_SECONDS": "0.05", "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", f"{fakes.__name__}", str(out), "2", "11"]
    for _ in range(times):
        run = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.5, 4.0))
        victims = children(run.pid) if workers else [run.pid]
        for victim in victims[:1]:
            os.kill(victim, signal.SIGKILL)
        try:
            assert not workers or run.wait(timeout=120) == 0
        finally:
            run.kill()
            run.wait()
        if (out / "manifest.json").exists():
            assert not [each for each in verify_dataset(out).problems if "yet" not in each]


def children(pid: int) -> list[int]:
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        command = (status.parent / "cmdline").read_bytes() if status.parent.exists() else b""
        if int(fields[1]) == pid and b"spawn_main" in command:
            found.append(int(status.parent.name))
    return found


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds processes in /proc")
@pytest.mark.parametrize("times", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_killed_parent_leaves_a_dataset_that_ends_as_if_nothing_had_been(whole: Path, tmp_path: Path, times: int):
    out = tmp_path / "set"
    kill_at_random(out, 1, times, workers=False)
    generate_dataset(small_recipe("episodes=11"), out, options=ONE, simulator=FAKE, resume=True)
    assert content(out) == content(whole)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds processes in /proc")
@pytest.mark.parametrize("seed", range(20))
def test_killed_worker_changes_nothing(whole: Path, tmp_path: Path, seed: int):
    out = tmp_path / "set"
    kill_at_random(out, seed, 1, workers=True)
    assert content(out) == content(whole)


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("files", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in (1, 3)), 4])
def test_run_that_ended_before_its_manifest_goes_on(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: int
):
    real, placed = Ledger.place, []

    def place_until_full(self: Ledger, name: str, data: bytes) -> None:
        if len(placed) == files:
            raise OSError(28, "No space left on device")
        placed.append(name)
        real(self, name, data)

    with monkeypatch.context() as patch:
        patch.setattr(Ledger, "place", place_until_full)
        with pytest.raises(OutputError, match="no space left on the disk"):
            generate_dataset(small_recipe("episodes=11"), tmp_path / "set", options=ONE, simulator=FAKE)
    assert read_manifest(tmp_path / "set") is None
    generate_dataset(small_recipe("episodes=11"), tmp_path / "set", options=ONE, simulator=FAKE, resume=True)
    assert content(tmp_path / "set") == content(whole)


FOREIGN = ("data/.mine.tmp", ".work/episode-00000003.parquet", "sub/x")
MORE_FOREIGN = (".mine.tmp", "data/notes.parquet", ".work/a")


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize(
    ("name", "is_begun"),
    [
        *((name, True) for name in FOREIGN),
        *(pytest.param(name, True, marks=pytest.mark.slow) for name in MORE_FOREIGN),
        ("sub/x", False),
    ],
)
def test_foreign_file_is_named_and_kept(whole: Path, tmp_path: Path, name: str, *, is_begun: bool):
    out = tmp_path / "set"
    shutil.copytree(whole, out) if is_begun else out.mkdir()
    (out / name).parent.mkdir(exist_ok=True)
    (out / name).write_text("mine")
    with pytest.raises(OutputError, match=f"holds ('{name}', not as magicsim wrote it|other files)"):
        generate_dataset(small_recipe("episodes=12"), out, options=ONE, simulator=FAKE, resume=True)
    assert (out / name).read_text() == "mine"
    (out / name).unlink()
    shutil.rmtree(out / "sub", ignore_errors=True)
    if not is_begun:
        shutil.rmtree(out)
    generate_dataset(small_recipe("episodes=12"), out, options=ONE, simulator=FAKE, resume=True)
    assert not verify_dataset(out).problems


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("name", ["README.md", "config.toml", "manifest.json", "sensors.parquet"])
def test_file_that_was_edited_is_not_replaced(whole: Path, tmp_path: Path, name: str):
    out = tmp_path / "set"
    shutil.copytree(whole, out)
    (out / name).write_bytes((out / name).read_bytes() + b"\n")
    changed = content(out)
    with pytest.raises(OutputError, match=f"{name}'"):
        generate_dataset(small_recipe("episodes=12"), out, options=ONE, simulator=FAKE, resume=True)
    assert content(out) == changed


@pytest.mark.usefixtures("in_process")
def test_damaged_episode_that_waited_is_simulated_again(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / "set"
    with monkeypatch.context() as patch:
        patch.setattr("magicsim.dataset.generate.Assembly.close_ready_shards", lambda *_: None)
        patch.setattr("magicsim.dataset.assembly.write_rows", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            generate_dataset(small_recipe("episodes=11"), out, options=ONE, simulator=FAKE)
    waiting = sorted((out / ".work").glob("*.parquet"))
    content_of = bytearray(waiting[0].read_bytes())
    content_of[100] ^= 1
    waiting[0].write_bytes(content_of)
    generate_dataset(small_recipe("episodes=11"), out, options=ONE, simulator=FAKE, resume=True)
    assert content(out) == content(whole)


@pytest.mark.usefixtures("in_process")
def test_run_that_ended_before_anything_was_finished_leaves_the_folder_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    out = tmp_path / "set"
    with monkeypatch.context() as patch:
        patch.setattr("magicsim.dataset.generate.Assembly.take", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            generate_dataset(small_recipe(), out, options=ONE, simulator=FAKE)
    assert not read_manifest(out).shards
    summary = generate_dataset(small_recipe(seed=9), out, options=ONE, simulator=FAKE)
    assert summary.failed == 0
    assert not verify_dataset(out).problems


def test_dataset_does_not_go_on_in_another_room_of_the_same_name(in_process: None, tmp_path: Path):
    def recipe(episodes: int, grey: int) -> Recipe:
        cv2.imwrite(str(tmp_path / "room.png"), np.full((4, 8, 3), grey, np.uint8))
        room = f"rig.room='{tmp_path / 'room.png'}'"
        return small_recipe(f"episodes={episodes}", "episodes_per_shard=1", room, "rig.ambient=[0.1,0.1,0.1]")

    generate_dataset(recipe(1, 10), tmp_path / "set", options=ONE, simulator=FAKE)
    other = recipe(2, 200)
    with pytest.raises(OutputError, match=r"of another recipe, which names files that have changed"):
        generate_dataset(other, tmp_path / "set", options=ONE, simulator=FAKE, resume=True)
    assert verify_dataset(tmp_path / "set").problems == []  # which is about the dataset, wherever its room is
    generate_dataset(recipe(2, 10), tmp_path / "set", options=ONE, simulator=FAKE, resume=True)


@pytest.mark.usefixtures("in_process")
def test_dataset_of_other_or_of_unknown_sources_does_not_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out, known = tmp_path / "set", versions()
    generate_dataset(small_recipe("episodes=11"), out, options=ONE, simulator=FAKE)
    monkeypatch.setattr("magicsim.dataset.generate.versions", lambda: known | {"sources": "0123456789abcdef"})
    line = "was begun with another version of sources: its results would differ; begin anew in another folder"
    with pytest.raises(OutputError, match=line):
        generate_dataset(small_recipe("episodes=12"), out, options=ONE, simulator=FAKE, resume=True)
    manifest = json.loads((out / MANIFEST).read_text())
    del manifest["versions"]["sources"]
    (out / MANIFEST).write_bytes(sealed(manifest))
    with pytest.raises(OutputError, match="was begun with unknown code"):
        generate_dataset(small_recipe("episodes=12"), out, options=ONE, simulator=FAKE, resume=True)


def test_force_that_an_object_does_not_reach_is_one_line_before_anything_is_written(
    in_process: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    reached = Reached(depth_mm=2.5, force_n=3.1, is_met=False, power=1.5, solves=3)
    asked: list[float] = []

    def press(design, placed, force_n, **_):
        asked.append(force_n)
        return reached

    monkeypatch.setattr("magicsim.dataset.rows.press_to_force", press)
    force = "force_n={low=4.0,high=6.0}"
    options = {"options": WorkerOptions(workers=1), "simulator": FAKE}
    with pytest.raises(
        ConfigError, match=r"^force_n = .* is not reached: 'sphere' presses with 3.1 N at the depth lim"
    ):
        generate_dataset(small_recipe(f"paths=[{{kind='touch',{force}}}]"), tmp_path / "set", **options)
    assert not (tmp_path / "set").exists()
    drawn = [each.force_n for each in draw_episodes(small_recipe(f"paths=[{{kind='touch',{force}}}]"))]
    assert asked == [max(drawn)]  # of the one kind of object
    generate_dataset(small_recipe(f"paths=[{{kind='touch',{force},depth_mm=1.0}}]"), tmp_path / "set", **options)


def test_table_of_sensors_has_rooms_that_draw_other_values():
    rooms = "rooms=[{room='dark'},{room='office',ambient={low=0.05,high=0.2}}]"
    sensors = draw_sensors(small_recipe(rooms), 8)
    ambient = pq.read_table(io.BytesIO(sensors_table(sensors))).column("drawn.sensor.ambient").to_numpy()
    dark = np.array([sensor.rig.room == "dark" for sensor in sensors])
    assert 0 < dark.sum() < len(dark)
    np.testing.assert_array_equal(np.isnan(ambient), dark)


def test_table_of_sensors_has_the_nodes_of_a_curved_face():
    [sensor] = draw_sensors(load_recipe("default", ["design=docs/examples/domed-sensor/block.toml"]), 1)
    [nodes] = pq.read_table(io.BytesIO(sensors_table([sensor])))["lattice_nodes_mm"].to_pylist()
    np.testing.assert_allclose(nodes, build_lattice(sensor.design).nodes_mm, atol=1e-12)
    assert len(set(np.array(nodes)[:, 2].round(6))) > 100


def test_columns_of_markers_have_a_row_for_each_marker():
    recipe = load_recipe("default", ["design=see-through-markers"])
    count = len(recipe.design.markers.centres_mm(recipe.design.footprint_mm))
    shapes = {each.name: each.feature.get("shape") for each in columns_of(recipe)}
    assert (shapes["markers_mm"], shapes["markers_px"]) == ([count, 3], [count, 2])
    assert count == 169
