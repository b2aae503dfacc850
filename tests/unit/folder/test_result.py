import errno
import os
import re
from pathlib import Path

import pytest

from magicsim.errors import OutputError, RenderError
from magicsim.folder import LISTING, MARKER, SIGNATURE, check_target, result_folder


def write_result(target: Path, name: str = "new.txt") -> None:
    with result_folder(target) as folder:
        (folder / name).write_text("content")
        (folder / MARKER).write_text(f"{SIGNATURE}\nschema_version = 1\n")


def write_half(path: Path) -> None:
    path.write_text("half")
    msg = "the work fails here"
    raise RenderError(msg)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_folder_appears_only_when_the_work_is_done(tmp_path: Path):
    with result_folder(tmp_path / "out") as folder:
        (folder / "part.txt").write_text("content")
        assert not (tmp_path / "out").exists()
    assert names(tmp_path) == ["out"]
    assert names(tmp_path / "out") == [LISTING, "part.txt"]


def test_earlier_result_is_replaced_as_a_whole(tmp_path: Path):
    write_result(tmp_path / "out", "old.txt")
    write_result(tmp_path / "out", "new.txt")
    assert names(tmp_path / "out") == [LISTING, MARKER, "new.txt"]
    assert names(tmp_path) == ["out"]


def test_error_leaves_the_earlier_result_and_nothing_else(tmp_path: Path):
    write_result(tmp_path / "out", "old.txt")
    with pytest.raises(RenderError), result_folder(tmp_path / "out") as folder:
        write_half(folder / "half.txt")
    assert names(tmp_path) == ["out"]
    assert "old.txt" in names(tmp_path / "out")


def test_interruption_leaves_nothing(tmp_path: Path):
    with pytest.raises(KeyboardInterrupt), result_folder(tmp_path / "out"):
        raise KeyboardInterrupt
    assert names(tmp_path) == []


def working(target: Path, purpose: str) -> Path:
    return target.with_name(f".{target.name}.0123456789abcdef.{purpose}")


def test_what_a_killed_run_left_empty_is_cleared(tmp_path: Path):
    (working(tmp_path / "out", "partial") / "frames").mkdir(parents=True)
    write_result(tmp_path / "out")
    assert names(tmp_path) == ["out"]


def test_what_a_killed_run_left_without_a_list_is_told_and_kept(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    left = working(tmp_path / "out", "partial")
    left.mkdir()
    (left / "thesis.txt").write_text("mine")
    write_result(tmp_path / "out")
    assert names(tmp_path) == [left.name, "out"]
    assert (left / "thesis.txt").read_text() == "mine"
    assert f"'{left}' was left by a run that was killed" in caplog.text


def test_result_of_which_a_killed_run_took_the_name_gets_it_back(tmp_path: Path):
    write_result(tmp_path / "out", "old.txt")
    (tmp_path / "out").rename(working(tmp_path / "out", "old"))
    with pytest.raises(RenderError), result_folder(tmp_path / "out") as folder:
        write_half(folder / "half.txt")
    assert names(tmp_path) == ["out"]
    assert "old.txt" in names(tmp_path / "out")


def test_half_result_of_a_name_that_ends_with_old_is_none(tmp_path: Path):
    left = tmp_path / ".run.0123456789abcdef.partial.old"
    left.mkdir()
    (left / "half.png").write_text("half")
    with pytest.raises(RenderError), result_folder(tmp_path / "run.old") as folder:
        write_half(folder / "half.txt")
    assert names(tmp_path) == [left.name]


def test_name_that_looks_like_an_earlier_working_folder_is_left_alone(tmp_path: Path):
    (tmp_path / ".out.partial").mkdir()
    (tmp_path / ".out.partial" / "thesis.txt").write_text("mine")
    write_result(tmp_path / "out")
    assert (tmp_path / ".out.partial" / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize("foreign", ["notes.txt", "frames/more.png", "empty/", "a/b/c.txt", ".hidden"])
def test_anything_foreign_in_a_result_is_named_and_kept(tmp_path: Path, foreign: str):
    write_result(tmp_path / "out")
    path = tmp_path / "out" / foreign
    path.parent.mkdir(parents=True, exist_ok=True)
    path.mkdir() if foreign.endswith("/") else path.write_text("mine")
    with pytest.raises(OutputError, match=f"holds '{foreign.split('/', maxsplit=1)[0]}.*not as magicsim wrote it"):
        write_result(tmp_path / "out")
    assert path.exists()
    assert names(tmp_path) == ["out"]


def test_file_that_was_changed_or_became_a_link_is_foreign(tmp_path: Path):
    write_result(tmp_path / "out")
    (tmp_path / "out" / "new.txt").write_text("contenT")
    with pytest.raises(OutputError, match=r"holds 'new\.txt', not as"):
        write_result(tmp_path / "out")
    (tmp_path / "mine.txt").write_text("content")
    (tmp_path / "out" / "new.txt").unlink()
    (tmp_path / "out" / "new.txt").symlink_to(tmp_path / "mine.txt")
    with pytest.raises(OutputError, match=r"holds 'new\.txt', not as"):
        write_result(tmp_path / "out")
    (tmp_path / "out" / "new.txt").unlink()
    write_result(tmp_path / "out")  # what was taken away is nobody's loss
    assert (tmp_path / "mine.txt").read_text() == "content"


def test_result_without_its_list_is_refused(tmp_path: Path):
    write_result(tmp_path / "out")
    (tmp_path / "out" / LISTING).write_text("{")
    with pytest.raises(OutputError, match="a result without its list"):
        write_result(tmp_path / "out")


def test_what_is_put_into_the_earlier_result_meanwhile_is_kept_and_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
):
    write_result(tmp_path / "out")
    with result_folder(tmp_path / "out") as folder:
        (folder / "newer.txt").write_text("content")
        (tmp_path / "out" / "notes.txt").write_text("mine")
    (kept,) = [path for path in tmp_path.iterdir() if path.name != "out"]
    assert kept.name.startswith("out.kept-")
    assert names(kept) == ["notes.txt"]
    assert str(kept) in caplog.text


def exchanged_within(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("magicsim.folder.target.os.path.ismount", lambda path: Path(path).name == "out")


def test_mount_point_gets_the_new_content_and_loses_the_old(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    exchanged_within(monkeypatch)
    (tmp_path / "out").mkdir()
    before = (tmp_path / "out").stat().st_ino
    write_result(tmp_path / "out", "old.txt")
    write_result(tmp_path / "out", "new.txt")
    assert names(tmp_path / "out") == [LISTING, MARKER, "new.txt"]
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out").stat().st_ino == before
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"holds 'notes\.txt'"):
        write_result(tmp_path / "out")


def test_folder_that_turns_out_not_to_be_renamed_gets_a_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write_result(tmp_path / "out", "old.txt")
    before, real = (tmp_path / "out").stat().st_ino, Path.rename

    def rename(self: Path, target: Path) -> Path:
        if self.name == "out":
            raise OSError(errno.EBUSY, "Device or resource busy")
        return real(self, target)

    monkeypatch.setattr(Path, "rename", rename)
    write_result(tmp_path / "out", "new.txt")
    assert names(tmp_path / "out") == [LISTING, MARKER, "new.txt"]
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out").stat().st_ino == before


@pytest.mark.parametrize("last", [1, 2, 3, 4, 5])
def test_exchange_that_fails_half_way_is_undone_and_nothing_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, last: int
):
    exchanged_within(monkeypatch)
    (tmp_path / "out").mkdir()
    write_result(tmp_path / "out", "old.txt")
    real, calls = Path.rename, []

    def rename(self: Path, target: Path) -> Path:
        calls.append(self)
        if len(calls) == last:
            raise OSError(errno.EIO, "Input/output error")
        return real(self, target)

    monkeypatch.setattr(Path, "rename", rename)
    with pytest.raises(OutputError, match="Input/output error; the result is whole in") as caught:
        write_result(tmp_path / "out", "new.txt")
    whole = Path(re.search("whole in '(.*)'", str(caught.value))[1])
    assert "old.txt" in names(tmp_path / "out")
    assert names(whole) == [LISTING, MARKER, "new.txt"]


def test_new_folder_has_no_list_and_replaces_nothing(tmp_path: Path):
    with result_folder(tmp_path / "out", is_listed=False) as folder:
        (folder / "part.txt").write_text("content")
    assert names(tmp_path / "out") == ["part.txt"]
    with pytest.raises(OutputError, match="holds other files"), result_folder(tmp_path / "out", is_listed=False):
        pass


def test_place_that_cannot_be_written_is_told_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    real = os.access
    monkeypatch.setattr("magicsim.folder.target.os.access", lambda path, how: path != tmp_path and real(path, how))
    with pytest.raises(OutputError, match=f"cannot write .*: '{tmp_path}' cannot be written"):
        check_target(tmp_path / "a" / "b")
    assert names(tmp_path) == []


def test_folder_below_a_file_is_told_before_any_work(tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=r"cannot write .*file/a/b: '.*file' is not a folder"):
        check_target(tmp_path / "file" / "a" / "b")
    assert names(tmp_path) == ["file"]


def test_loop_of_links_is_one_line(tmp_path: Path):
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    for out in (tmp_path / "a", tmp_path / "a" / "out"):
        with pytest.raises(OutputError, match="Too many levels of symbolic links"):
            write_result(out)
    assert names(tmp_path) == ["a", "b"]


def test_missing_parents_are_made_and_an_empty_folder_is_taken(tmp_path: Path):
    (tmp_path / "empty").mkdir()
    write_result(tmp_path / "empty")
    write_result(tmp_path / "a" / "b" / "out")
    assert (tmp_path / "empty" / "new.txt").is_file()
    assert (tmp_path / "a" / "b" / "out" / "new.txt").is_file()


@pytest.mark.parametrize("foreign", ["thesis.txt", MARKER])
def test_folder_of_somebody_else_is_refused_and_kept(tmp_path: Path, foreign: str):
    """A folder that happens to hold a `config.toml` is somebody else's too."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / foreign).write_text('title = "my site"\n')
    with pytest.raises(OutputError, match="holds other files"):
        write_result(tmp_path / "mine")
    assert names(tmp_path / "mine") == [foreign]
    assert names(tmp_path) == ["mine"]


def test_file_in_the_place_of_the_folder_is_refused_and_kept(tmp_path: Path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(OutputError, match="is a file"):
        write_result(tmp_path / "out")
    assert (tmp_path / "out").read_text() == "mine"


def test_current_folder_may_be_the_target(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    write_result(Path())
    assert (tmp_path / "here" / "new.txt").is_file()
    assert names(tmp_path) == ["here"]


def test_folder_that_cannot_be_made_is_an_output_error(tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="cannot write"):
        write_result(tmp_path / "file" / "out")


def test_target_that_does_not_exist_yet_is_accepted(tmp_path: Path):
    check_target(tmp_path / "new")
    assert names(tmp_path) == []
