import numpy as np
import pytest
from detectors.conftest import grid_frame, near_frame

from magicsim.detectors import FrameClass
from magicsim.errors import ConfigError, FrameError
from magicsim.judge.recorded import read_episode


@pytest.fixture
def folder(tmp_path, save):
    save(tmp_path / "rest.png", grid_frame())
    save(tmp_path / "near.png", near_frame())
    return tmp_path


def label(folder, text):
    (folder / "labels.csv").write_text(text)
    return folder


def test_references_and_labelled_frames_are_told_apart_in_their_order(folder):
    rows = ["rest.png,Reference,", "rest.png,Reference,", "near.png,Near,x", "rest.png,,between", "rest.png, Clear ,"]
    text = "\n".join(["file,class,note", *rows, ""])
    found = read_episode(label(folder, text))
    assert len(found.references) == 2
    assert list(found.classes) == [FrameClass.NEAR, None, FrameClass.CLEAR]
    assert np.array_equal(found.frames[0], near_frame())
    assert np.array_equal(found.frames[1], grid_frame())


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("file,klass\nrest.png,Clear\n", "has no column class"),
        ("", "has no column file, class"),
        ("file,class\nrest.png,Reference\nnear.png,Nera\n", r"line 3: unknown class 'Nera' \(did you mean 'Near'\?\)"),
        ("file,class\nnear.png,Near\n", "names no frame of class Reference"),
    ],
)
def test_table_that_cannot_be_used_is_one_line(folder, text, named):
    with pytest.raises(ConfigError, match=named) as caught:
        read_episode(label(folder, text))
    assert "\n" not in str(caught.value)


def test_missing_image_is_named(folder):
    with pytest.raises(FrameError, match=r"none\.png"):
        read_episode(label(folder, "file,class\nnone.png,Reference\n"))
