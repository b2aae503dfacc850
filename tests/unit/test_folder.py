from pathlib import Path

import pytest

from magicsim.errors import OutputError, RenderError
from magicsim.folder import MARKER, SIGNATURE, check_target, result_file, result_folder


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
    assert names(tmp_path / "out") == ["part.txt"]


def test_earlier_result_is_replaced_as_a_whole(tmp_path: Path):
    write_result(tmp_path / "out", "old.txt")
    write_result(tmp_path / "out", "new.txt")
    assert names(tmp_path / "out") == [MARKER, "new.txt"]
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


def test_leftover_of_a_killed_run_is_cleared(tmp_path: Path):
    (tmp_path / ".out.partial").mkdir()
    (tmp_path / ".out.partial" / "stale.txt").write_text("stale")
    write_result(tmp_path / "out")
    assert names(tmp_path) == ["out"]
    assert "stale.txt" not in names(tmp_path / "out")


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


def test_file_takes_its_name_only_when_it_is_complete(tmp_path: Path):
    target = tmp_path / "deep" / "image.npy"
    with result_file(target) as partial:
        assert partial.suffix == ".npy"
        partial.write_bytes(b"content")
        assert not target.exists()
    assert names(target.parent) == ["image.npy"]


def test_error_keeps_the_earlier_file_and_nothing_else(tmp_path: Path):
    target = tmp_path / "image.npy"
    target.write_text("old")
    with pytest.raises(RenderError), result_file(target) as partial:
        write_half(partial)
    assert target.read_text() == "old"
    assert names(tmp_path) == ["image.npy"]


def test_folder_in_the_place_of_the_file_is_refused(tmp_path: Path):
    (tmp_path / "image.npy").mkdir()
    with pytest.raises(OutputError, match="is a folder"), result_file(tmp_path / "image.npy"):
        pass
    assert names(tmp_path) == ["image.npy"]


def test_file_below_a_file_is_an_output_error(tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="cannot write"), result_file(tmp_path / "file" / "image.npy"):
        pass
