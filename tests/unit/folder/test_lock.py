import multiprocessing
import time
from pathlib import Path

import pytest

from magicsim.errors import OutputError
from magicsim.folder.target import sole_writer


def test_lock_is_gone_afterwards_and_after_an_error(tmp_path: Path):
    with sole_writer(tmp_path / "out"):
        assert [path.name for path in tmp_path.iterdir()] == [".out.magicsim-lock"]
    with pytest.raises(ZeroDivisionError), sole_writer(tmp_path / "out"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_second_writer_is_refused_by_every_way_to_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "out").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "out")
    monkeypatch.chdir(tmp_path / "out")
    with sole_writer(tmp_path / "out"):
        for way in (tmp_path / "out", tmp_path / "link", Path(), Path("../out")):
            with pytest.raises(OutputError, match="is being written by another run"), sole_writer(way):
                pass
        with sole_writer(tmp_path / "another"):
            pass


def test_file_of_that_name_that_holds_something_is_kept(tmp_path: Path):
    (tmp_path / ".out.magicsim-lock").write_text("mine")
    with sole_writer(tmp_path / "out"):
        pass
    assert (tmp_path / ".out.magicsim-lock").read_text() == "mine"


def enter_often(out: Path, log: Path, times: int) -> None:
    for _ in range(times):
        try:
            with sole_writer(out):
                (log / "inside").mkdir()  # fails where somebody else is inside
                time.sleep(0.0005)
                (log / "inside").rmdir()
        except OutputError:
            time.sleep(0.0002)
        except FileExistsError:
            (log / "two-at-once").touch()


def test_never_two_at_once(tmp_path: Path):
    (tmp_path / "log").mkdir()
    context = multiprocessing.get_context("spawn")
    runs = [context.Process(target=enter_often, args=(tmp_path / "out", tmp_path / "log", 300)) for _ in range(4)]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert [run.exitcode for run in runs] == [0] * 4
    assert list((tmp_path / "log").iterdir()) == []
