import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.config.program import versions
from magicsim.errors import OutputError
from magicsim.sweep.comparison import run_sweep
from magicsim.workers.attempt import WorkerOptions

from .fakes import FAILING, FAKE, small_sweep

ONE = WorkerOptions(workers=1, retries=0)


def files(out: Path) -> dict[str, bytes]:
    return {each.relative_to(out).as_posix(): each.read_bytes() for each in out.rglob("*") if each.is_file()}


@pytest.mark.usefixtures("in_process")
def test_folder_holds_results_table_pictures_page_and_config(out: Path):
    summary = run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    assert (summary.designs, summary.failed) == (4, 0)
    assert summary.best == {
        "design": 0, "values": {"design.cell_mm": 0.8, "design.skin_mm": 0.5}, "measure": "sensitivity_per_n",
        "value": pytest.approx(0.69), "low": pytest.approx(0.59), "high": pytest.approx(0.79),
    }  # fmt: skip
    assert summary.leaders == [0]
    assert summary.verdicts["localisation_mm"] == "told apart"
    assert summary.verdicts["contact_auc"] == "saturated"
    assert summary.front == [0, 2]
    assert Path(summary.report).read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    rows = list(csv.DictReader((out / "sweep.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(row["design.skin_mm"]) for row in rows] == [0.5, 1.0, 0.5, 1.0]
    table = pq.read_table(out / "sweep.parquet")
    assert table["shore_a"].to_pylist() == [27.0, 29.0, 27.0, 29.0]
    assert table.schema.field("force_1mm_n").metadata[b"unit"] == b"N"
    assert len(list((out / "frames").iterdir())) == 8
    assert json.loads((out / "sweep.json").read_text())["is_complete"]


@pytest.mark.usefixtures("in_process")
def test_failed_design_is_reported_and_stops_no_other(out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("FAKE_CRASH", str(tmp_path / "never"))
    summary = run_sweep(small_sweep(), out, options=ONE, judge=FAILING)
    assert (summary.designs, summary.failed) == (3, 1)
    assert json.loads((out / "sweep.json").read_text())["failed"] == {"1": "no cell fits along z"}
    assert json.loads((out / "errors.jsonl").read_text())["design"] == 1
    assert "no cell fits along z" in Path(summary.report).read_text(encoding="utf-8")


@pytest.mark.usefixtures("in_process")
def test_resuming_judges_only_what_is_left(out: Path):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    whole = files(out)
    (out / "designs" / "00002.json").unlink()
    (out / "designs" / "00003.json").unlink()
    seen = []
    run_sweep(small_sweep(), out, options=ONE, resume=True, judge=FAKE, progress=lambda *told: seen.append(told))
    assert seen == [(3, 4, 0), (4, 4, 0)]
    assert files(out) == whole


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("name", ["designs/00003.json", "sweep.csv", "report.html", "sweep.json", "config.toml"])
def test_file_that_was_changed_is_named_and_kept(out: Path, name: str):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    (out / name).write_bytes((out / name).read_bytes() + b"\n")
    changed = files(out)
    with pytest.raises(OutputError, match=f"holds '{name}', not as magicsim wrote it|{name}' has changed since it was"):
        run_sweep(small_sweep(), out, options=ONE, resume=True, judge=FAKE)
    assert files(out) == changed


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("name", [".mine.tmp", "designs/notes.txt", ".work/a", "frames/.x.tmp"])
def test_foreign_file_is_named_and_kept(out: Path, name: str):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    (out / name).parent.mkdir(exist_ok=True)
    (out / name).write_text("mine")
    with pytest.raises(OutputError, match=f"holds '{name}', not as magicsim wrote it"):
        run_sweep(small_sweep(), out, options=ONE, resume=True, judge=FAKE)
    assert (out / name).read_text() == "mine"


@pytest.mark.usefixtures("in_process")
def test_other_objectives_need_no_new_work(out: Path):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    seen = []
    sweep = small_sweep("objectives=[{measure='shore_a',better='higher'}]")
    summary = run_sweep(sweep, out, options=ONE, resume=True, judge=FAKE, progress=lambda *told: seen.append(told))
    assert seen == []
    assert (summary.front, summary.leaders, summary.best) == ([1, 3], [1, 3], None)


@pytest.mark.usefixtures("in_process")
def test_folder_of_another_sweep_or_of_anything_else_is_refused(out: Path):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    with pytest.raises(OutputError, match="holds a sweep already; --resume goes on"):
        run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    with pytest.raises(OutputError, match="holds another sweep"):
        run_sweep(small_sweep("seed=9"), out, options=ONE, resume=True, judge=FAKE)
    (out.parent / "notes.txt").touch()
    with pytest.raises(OutputError, match="holds other files"):
        run_sweep(small_sweep(), out.parent, options=ONE, judge=FAKE)


@pytest.mark.slow
def test_killed_process_loses_its_own_design_alone_and_resuming_finds_it(
    out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    crash = tmp_path / "crash"
    crash.touch()
    monkeypatch.setenv("FAKE_CRASH", str(crash))
    summary = run_sweep(small_sweep(), out, options=ONE, judge=FAILING)
    assert (summary.designs, summary.failed) == (2, 2)
    crash.unlink()
    summary = run_sweep(small_sweep(), out, options=ONE, resume=True, judge=FAILING)
    assert (summary.designs, summary.failed) == (3, 1)


@pytest.mark.slow
def test_killed_run_ends_with_the_results_of_one_that_was_not(out: Path, tmp_path: Path):
    command = [sys.executable, "-m", "sweep.fakes", str(out)]
    paths = [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "FAKE_SECONDS": "0.5", "PYTHONPATH": os.pathsep.join(paths)}
    run = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while not list(out.glob("designs/*.json")) and time.monotonic() < deadline:
        time.sleep(0.05)
    run.send_signal(signal.SIGKILL)
    run.wait()
    assert 1 <= len(list(out.glob("designs/*.json"))) < 4
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == {"designs": 4}
    whole = tmp_path / "whole"
    run_sweep(small_sweep(), whole, options=ONE, judge=FAKE)
    assert files(out) == files(whole)


@pytest.mark.usefixtures("in_process")
def test_sweep_of_other_sources_does_not_go_on(out: Path, monkeypatch: pytest.MonkeyPatch):
    run_sweep(small_sweep(), out, options=ONE, judge=FAKE)
    known = versions() | {"sources": "0123456789abcdef"}
    monkeypatch.setattr("magicsim.sweep.comparison.versions", lambda: known)
    with pytest.raises(OutputError, match="was begun with another version of sources"):
        run_sweep(small_sweep(), out, options=ONE, judge=FAKE, resume=True)
