from pathlib import Path

import pytest

from magicsim.errors import OutputError, RenderError
from magicsim.folder import result_file

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
