import json
import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from magicsim.errors import OutputError
from magicsim_experiments.study import running
from magicsim_experiments.study.running import estimate_study, run_study
from magicsim_experiments.study.study_file import load_study

from .fakes import CALLS, KINDS

BEAM = Path(__file__).with_name("beam.toml")


def run(out: Path, *overrides: str, resume: bool = False, **options):
    study = load_study(BEAM, overrides, kinds=KINDS)
    return run_study(study, out, resume=resume, variant=lambda: "none", **options)


def contents(out: Path) -> dict[str, bytes]:
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}


@pytest.mark.usefixtures("in_process")
def test_study_leaves_tables_json_page_and_index(out: Path):
    told, announced = [], []
    summary = run(out, progress=lambda *each: told.append(each), announce=announced.extend)
    assert summary.headline["most_mm"] == pytest.approx(
        4 * 4000 / load_study(BEAM, kinds=KINDS).config.design.height_mm ** 4
    )
    table = pq.read_table(out / "tables/tips.parquet")
    assert table.column("force_n").to_pylist() == [1.0, 2.0, 3.0, 4.0]
    assert table.schema.field("tip_mm").metadata[b"unit"] == b"mm"
    results = json.loads((out / "results.json").read_text())
    assert results["tables"]["answers"][0] == {"truth": "a", "answer": "a", "count": 3, "right": True}
    page = (out / "report.html").read_text()
    assert "default-src 'none'" in page
    assert "A beam &lt;of&gt; theory." in page
    assert "<svg" in page
    index = json.loads((out / "study.json").read_text())
    assert index["is_complete"]
    assert set(index["files"]) == set(contents(out)) - {"study.json"}
    assert [each.core_seconds for each in announced] == [2.0]
    assert told[-1][:2] == (2.0, 2.0)


@pytest.mark.usefixtures("in_process")
def test_killed_study_resumes_to_the_same_bytes(out: Path, tmp_path: Path, monkeypatch):
    run(tmp_path / "whole")
    place = "magicsim.folder.ledger.Ledger.place"
    from magicsim.folder.ledger import Ledger

    kept, count = Ledger.place, iter(range(100))

    def killed(self, name, content):
        if next(count) == 4:
            raise KeyboardInterrupt
        kept(self, name, content)

    monkeypatch.setattr(place, killed)
    with pytest.raises(KeyboardInterrupt):
        run(out)
    monkeypatch.setattr(place, kept)
    CALLS.clear()
    with pytest.raises(OutputError, match="holds an unfinished study already; --resume"):
        run(out)
    run(out, resume=True)
    assert 0 < len(CALLS) < 4
    assert contents(out) == contents(tmp_path / "whole")
    CALLS.clear()
    run(out, resume=True)
    assert not CALLS
    assert contents(out) == contents(tmp_path / "whole")


@pytest.mark.usefixtures("in_process")
def test_refused_piece_is_a_row_and_a_failed_one_is_tried_again(out: Path):
    run(out / "refused", "forces_n=[1.0, 10.0]")
    table = pq.read_table(out / "refused/tables/tips.parquet").to_pylist()
    assert (table[1]["tip_mm"], table[1]["why"]) == (None, "the beam buckles")
    with pytest.raises(OutputError, match=r"1 pieces of 'tips' have no result .*out of luck.*--resume"):
        run(out / "failed", "forces_n=[1.0, 7.0]")
    CALLS.clear()
    with pytest.raises(OutputError, match="out of luck"):
        run(out / "failed", "forces_n=[1.0, 7.0]", resume=True)
    assert CALLS == [7.0]


@pytest.mark.usefixtures("in_process")
def test_study_of_other_code_is_not_gone_on_with(out: Path, monkeypatch):
    run(out)
    known = running.versions("magicsim_experiments") | {"magicsim_experiments": "0123456789abcdef"}
    monkeypatch.setattr(running, "versions", lambda *_: known)
    with pytest.raises(OutputError, match="was begun with another version of magicsim_experiments"):
        run(out, resume=True)


def test_foreign_folder_another_study_and_changed_files_are_refused(out: Path):
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"holds other files \('mine.txt'\)"):
        run(out)
    shutil.rmtree(out)
    run(out)
    with pytest.raises(OutputError, match="holds another study"):
        run(out, "forces_n=[2.0]", resume=True)
    (out / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"'mine\.txt', not as magicsim wrote it"):
        run(out, resume=True)
    (out / "mine.txt").unlink()
    (out / "results.json").write_text("{}")
    with pytest.raises(OutputError, match=r"results\.json"):
        run(out, resume=True)


def test_pieces_are_computed_by_processes(out: Path):
    from magicsim.workers.attempt import choose_workers

    summary = run(out, "forces_n=[1.0]", options=choose_workers(1))
    assert Path(summary.report).is_file()


def test_estimate_leaves_out_what_is_done(out: Path):
    study = load_study(BEAM, kinds=KINDS)
    assert [each.core_seconds for each in estimate_study(study, processes=2)] == [2.0]
    assert [each.core_seconds for each in estimate_study(study, processes=2, folder=out)] == [2.0]
