import errno
import os
from pathlib import Path

import pytest

from magicsim.errors import OutputError, RenderError
from magicsim.folder import check_file, result_file

from .test_result import names, write_half


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


@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("file/a.csv", "'.*file' is not a folder"),
        ("file/deep/a.csv", "'.*file' is not a folder"),
        ("loop/a.csv", "cannot write .*loop/a.csv: Too many levels of symbolic links"),
        ("gone/a.csv", "cannot write .*: No such file"),
        (".", "is a folder; name a file"),
        (f"{'z' * 300}.csv", "File name too long"),
        (f"{'z' * 240}.csv", "File name too long"),
        (f"missing/{'z' * 300}.csv", "File name too long"),
    ],
)
def test_file_that_cannot_be_written_is_told_before_any_work(tmp_path: Path, name: str, named: str):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    with pytest.raises(OutputError, match=named):
        check_file(tmp_path / name)
    assert names(tmp_path) == ["file", "gone", "loop"]


def test_check_of_a_file_leaves_nothing_and_makes_no_folder(tmp_path: Path):
    check_file(tmp_path / "a" / "b" / "c.csv")
    assert names(tmp_path) == []


def test_place_in_which_nothing_can_be_made_is_told_whatever_its_rights_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def refuse(path: Path, *_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(OutputError, match=r"a\.csv: Read-only file system"):
        check_file(tmp_path / "a.csv")
