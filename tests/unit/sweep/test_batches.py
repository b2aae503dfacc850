import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from magicsim.errors import ConfigError, OutputError
from magicsim.sweep.comparison import run_sweep
from magicsim.sweep.result import FOLDER, DesignResult, read_results
from magicsim.sweep.sweep_file import load_sweep
from magicsim.workers.attempt import WorkerOptions
from sweep.fakes import FAKE
from sweep.searched import PARTLY, QUADRATIC, searching, shares
from sweep.test_comparison import files

pytest.importorskip("optuna")
ONE = WorkerOptions(workers=1, retries=0)


def values(out: Path, count: int) -> list[dict[str, float]]:
    return [each.values for each in read_results(out, count)]


def gap_to_front(results: list[DesignResult]) -> float:
    """Mean distance of places on the front (localisation, unknowns) to the nearest design."""
    share = np.linspace(0, 0.5, 51)
    front = np.stack([share**2, (0.5 - share) ** 2], axis=1)
    found = np.array([[each.measures[name].value for name in ("localisation_mm", "unknowns")] for each in results])
    return float(np.linalg.norm(front[:, None] - found[None], axis=2).min(axis=1).mean())


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("seed", [1, *(pytest.param(each, marks=pytest.mark.slow) for each in (2, 3))])
def test_search_comes_closer_to_the_front_than_as_many_sobol_points(out: Path, tmp_path: Path, seed: int):
    run_sweep(searching(64, f"seed={seed}"), out, options=ONE, judge=QUADRATIC)
    run_sweep(searching(64, f"seed={seed}", sampling="sobol"), tmp_path / "sobol", options=ONE, judge=QUADRATIC)
    searched, spread = (gap_to_front(read_results(folder, 64)) for folder in (out, tmp_path / "sobol"))
    assert searched < 0.6 * spread


@pytest.mark.usefixtures("in_process")
def test_search_starts_from_the_sobol_points_of_its_seed(out: Path, tmp_path: Path):
    run_sweep(searching(12), out, options=ONE, judge=QUADRATIC)
    run_sweep(searching(8, sampling="sobol"), tmp_path / "sobol", options=ONE, judge=QUADRATIC)
    assert values(out, 8) == values(tmp_path / "sobol", 8)
    assert len(values(out, 12)) == 12


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("lost", [pytest.param(tuple(range(10, 24)), marks=pytest.mark.slow), (3, 9, 17, 21)])
def test_what_is_lost_is_judged_again_and_nothing_else_changes(out: Path, lost: tuple[int, ...]):
    run_sweep(searching(24), out, options=ONE, judge=QUADRATIC)
    whole, told = files(out), []
    for index in lost:
        (out / "designs" / f"{index:05d}.json").unlink()
    run_sweep(
        searching(24), out, options=ONE, resume=True, judge=QUADRATIC, progress=lambda *each: told.append(each)
    )  # fmt: skip
    assert len(told) == len(lost)
    assert files(out) == whole


@pytest.mark.usefixtures("in_process")
def test_design_of_another_history_is_judged_anew(out: Path):
    run_sweep(searching(16), out, options=ONE, judge=QUADRATIC)
    whole = files(out)
    other = (out / "designs" / "00013.json").read_text().replace('"index": 13', '"index": 12')
    FOLDER.open_ledger(out).place("designs/00012.json", other.encode())
    run_sweep(searching(16), out, options=ONE, resume=True, judge=QUADRATIC)
    assert files(out) == whole


@pytest.mark.usefixtures("in_process")
def test_failed_designs_stay_failed_and_the_search_goes_on(out: Path):
    summary = run_sweep(searching(24), out, options=ONE, judge=PARTLY)
    assert summary.designs + summary.failed == 24
    assert summary.failed > 3
    assert summary.designs > 8
    whole = files(out)
    (out / "designs" / f"{read_results(out, 24)[-1].index:05d}.json").unlink()
    again = run_sweep(searching(24), out, options=ONE, resume=True, judge=PARTLY)
    assert (again.designs, again.failed) == (summary.designs, summary.failed)
    assert values(out, 24) == [json.loads(whole[name])["values"] for name in sorted(whole) if "designs/" in name]


@pytest.mark.usefixtures("in_process")
def test_failures_of_further_designs_are_told_and_recorded_while_the_search_runs(out: Path):
    told, recorded = [], []

    def progress(*each: int) -> None:
        told.append(each)
        recorded.append(set(json.loads((out / "sweep.json").read_text())["failed"]))

    beyond = "also=[{'design.cell_mm'=0.79}]"  # what `PARTLY` cannot build
    summary = run_sweep(searching(12, beyond), out, options=ONE, judge=PARTLY, progress=progress)
    assert told[0] == (1, 13, 1)
    assert [failed for _, _, failed in told] == sorted(failed for _, _, failed in told)
    assert told[-1][2] == summary.failed
    assert "12" in recorded[-1]


@pytest.mark.usefixtures("in_process")
def test_design_that_is_chosen_again_is_judged_once(out: Path):
    swept = ("swept=[{field='design.skin_mm',values=[0.5,1.0,1.5]}]", "measures=['force_1mm_n']")
    objective = "objectives=[{measure='force_1mm_n',better='lower'}]"
    sweep = searching(12, *swept, objective, "also=[{'design.cell_mm'=1.2},{'design.cell_mm'=1.4}]")
    told = []
    summary = run_sweep(sweep, out, options=ONE, judge=FAKE, progress=lambda *each: told.append(each))
    assert summary.designs == 5
    assert [each.index for each in read_results(out, 14)][-2:] == [12, 13]
    assert told[:2] == [(1, 14, 0), (2, 14, 0)]
    again = run_sweep(sweep, out, options=ONE, resume=True, judge=FAKE, progress=lambda *each: told.append(each))
    assert (again.designs, len(told)) == (5, 5)


@pytest.mark.usefixtures("in_process")
def test_limits_draw_the_search_and_rule_the_front(out: Path, tmp_path: Path):
    limit = "search.limits=[{measure='printability',high=0.3}]"
    summary = run_sweep(searching(48, limit), out, options=ONE, judge=QUADRATIC)
    results = {each.index: each for each in read_results(out, 48)}
    assert summary.front
    assert all(shares(results[index].values)[0] <= 0.3 for index in summary.front)
    run_sweep(searching(48), tmp_path / "free", options=ONE, judge=QUADRATIC)
    inside, free = (
        sum(shares(each)[0] <= 0.3 for each in found[8:]) for found in (values(out, 48), values(tmp_path / "free", 48))
    )
    assert inside > free


@pytest.mark.usefixtures("in_process")
def test_other_objectives_are_another_search(out: Path):
    run_sweep(searching(8), out, options=ONE, judge=QUADRATIC)
    with pytest.raises(OutputError, match="holds another sweep"):
        run_sweep(
            searching(8, "objectives=[{measure='unknowns'}]"), out, options=ONE, resume=True, judge=QUADRATIC
        )  # fmt: skip


def test_field_that_does_not_exist_is_named_before_anything_is_judged(out: Path):
    with pytest.raises(ConfigError, match="did you mean 'skin_mm'"):
        run_sweep(searching(8, "swept=[{field='design.skn_mm',low=1,high=2}]"), out, options=ONE, judge=QUADRATIC)
    assert not out.exists()


def test_shipped_search_names_fields_that_exist():
    sweep = load_sweep("print-search")
    assert (sweep.sampling, sweep.count) == ("search", 64)


@pytest.mark.slow
def test_number_of_workers_changes_no_design(out: Path, tmp_path: Path):
    run_sweep(searching(16), out, options=ONE, judge=QUADRATIC)
    run_sweep(searching(16), tmp_path / "two", options=WorkerOptions(workers=2), judge=QUADRATIC)
    assert files(out) == files(tmp_path / "two")


@pytest.mark.slow
def test_killed_search_ends_with_the_designs_of_one_that_was_not(out: Path, tmp_path: Path):
    command = [sys.executable, "-m", "sweep.searched", str(out)]
    paths = [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "FAKE_SECONDS": "0.2", "PYTHONPATH": os.pathsep.join(paths)}
    run = subprocess.Popen(command, env=environment)
    deadline = time.monotonic() + 120
    while len(list(out.glob("designs/*.json"))) < 9 and time.monotonic() < deadline:
        time.sleep(0.05)
    run.send_signal(signal.SIGKILL)
    run.wait()
    assert 9 <= len(list(out.glob("designs/*.json"))) < 16
    subprocess.run(command, env=environment, check=True)
    whole = tmp_path / "whole"
    run_sweep(searching(16), whole, options=ONE, judge=QUADRATIC)
    assert files(out) == files(whole)
