import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.config.presets import find_preset

from .conftest import Shell
from .small import settings


def test_plan_prints_decisions_with_stage_and_reason(shell: Shell):
    found = shell.json("plan", "demo")
    assert set(found) == {"kept", "left_out", "warnings"}
    assert found["warnings"] == []
    for decision in [*found["kept"], *found["left_out"]]:
        assert set(decision) == {"stage", "reason"}


def test_plan_without_json_is_text_for_people(shell: Shell):
    done = shell("plan", "near")
    assert done.code == 0
    assert "kept:\n  grid: 25 x 34 x 6 cells of 0.796 x 0.794 x 0.733 mm" in done.out
    assert "\n  mesh and BVH update: 1 of 1 frames: something moved\n" in done.out


def test_plan_of_a_design_is_that_of_the_demo_on_it_with_warnings(shell: Shell, tmp_path: Path):
    assert shell.json("plan", "uniform-block") == shell.json("plan", "demo", "--set", "design=uniform-block")
    text = (find_preset("design", "mini-magictac")).read_text().replace("[24.0, 32.0]", "[8.0, 16.0]")
    (tmp_path / "small.toml").write_text(text)
    camera, thing, rim = shell.json("plan", "small.toml")["warnings"]
    assert "the camera sees past the block of 8 x 16 mm" in camera
    assert "the object is larger than the sensor: 10 x 10 mm" in thing
    assert "presses on the rim" in rim


def test_earlier_result_is_told_of_before_any_work(shell: Shell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    arguments = ["simulate", "rest", "--out", "out", *settings("output.report=false", "output.preview=false")]
    assert "earlier result" not in shell(*arguments).err
    monkeypatch.setattr("magicsim.cli.simulate.limit_threads", lambda _: sys.exit(9))  # what comes right after
    done = shell(*arguments)
    assert done.code == 9
    assert done.err.startswith("'out' holds an earlier result: it stays until the new one is whole")


def test_plan_notices_a_mesh_file_that_is_not_there(shell: Shell):
    assert "nowhere.stl" in shell.refusal("plan", "near", "--set", "object={kind='mesh',path='nowhere.stl'}")


def test_override_and_seed_reach_the_scene(shell: Shell):
    found = shell.json(
        "plan", "near", "--set", "keyframes=[{frame=0}, {frame=6}]", "--set", "references=9", "--seed", 4
    )
    reasons = {decision["stage"]: decision["reason"] for decision in found["kept"]}
    assert reasons["reference frames"].startswith("9 frames")
    assert "seed = -4" in shell.refusal("plan", "near", "--seed", "-4")


@pytest.mark.parametrize("command", [["simulate", "near"], ["demo"]])
def test_folder_that_holds_other_files_is_refused_before_any_work(shell: Shell, tmp_path: Path, command: list[str]):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "config.toml").write_text("title = 'not ours'")
    assert "holds other files" in shell.refusal(*command, "--out", "out")
    assert (tmp_path / "out" / "config.toml").read_text() == "title = 'not ours'"


@pytest.mark.slow
def test_simulate_prints_the_contract_and_leaves_a_folder(shell: Shell, tmp_path: Path):
    found = shell.json("simulate", "near", "--out", "out", *settings())
    assert {"frames", "seconds", "variant", "contact_accuracy", "proximity_accuracy", "report"} <= set(found)
    assert found["frames"] == 7
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "config.toml", "episode.parquet", "frames", "lattice.parquet", "preview.webp", "report.html",
    ]  # fmt: skip
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    # The written configuration is a scene that runs again, in the same place.
    again = shell.json("simulate", tmp_path / "out" / "config.toml", "--out", "out")
    assert again["frames"] == 7


def test_no_frame_is_labelled_untouched_with_an_object_inside_the_block(shell: Shell, tmp_path: Path):
    ball = ["object={kind='sphere',radius_mm=0.05}", "keyframes=[{frame=0,gap_mm=-0.2}]"]
    told = shell.refusal("simulate", "near", "--out", "out", *settings(*ball, "design.lattice.cells_across=0"))
    assert "lies 0.2 mm inside the block" in told
    assert list(tmp_path.iterdir()) == []


def test_frames_that_no_detector_can_judge_are_kept(shell: Shell, tmp_path: Path):
    found = shell.json("simulate", "rest", "--out", "out", *settings("references=1"))
    assert "too few" in found["not_judged"]
    assert (found["contact_accuracy"], found["proximity_accuracy"]) == (None, None)
    assert len(list((tmp_path / "out" / "frames").iterdir())) == found["frames"] == 2
    columns = pq.read_schema(tmp_path / "out" / "episode.parquet").names
    assert "gap_mm" in columns
    assert "calibrated_contact" not in columns


def test_mcap_is_written_beside_the_frames_of_a_simulation(shell: Shell, tmp_path: Path, monkeypatch):
    pytest.importorskip("foxglove")
    reader = pytest.importorskip("mcap.reader")
    small = settings("output.report=false", "output.preview=false", "keyframes=[{frame=0, gap_mm=1.0}]")
    found = shell.json("simulate", "near", "--out", "out", "--mcap", *small)
    with (tmp_path / "out" / "episode.mcap").open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    counts = {
        channel.topic: summary.statistics.channel_message_counts[key] for key, channel in summary.channels.items()
    }
    assert counts["/tactile/image"] == counts["/tactile/truth"] == found["frames"] == 7
    monkeypatch.setitem(sys.modules, "foxglove", None)
    monkeypatch.delitem(sys.modules, "magicsim.dataset.export.mcap")
    assert "pip install 'magicsim[mcap]'" in shell.refusal("simulate", "near", "--out", "out", "--mcap", *small)
