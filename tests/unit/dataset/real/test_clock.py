"""Frames of a video and rows of a table find each other on two clocks, or it is told how they miss."""

import re
from pathlib import Path

import numpy as np
import pytest

from magicsim.dataset.frames import open_frames
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.inspection import Inspection, inspect_real
from magicsim.dataset.real.writing import write_real
from magicsim.detectors.source import read_source
from magicsim.errors import ConfigError

from .drawn import describe, pressed, untouched, video, write_csv

TIMES_S = [round(0.1 * number, 3) for number in range(20)]
FORCES_N = [0.0] * 10 + [0.3, 0.6, 0.9, 1.0, 1.0, 0.9, 0.6, 0.3, 0.0, 0.0]


@pytest.fixture(autouse=True)
def _kept(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))


def recording(
    folder: Path, clock=lambda time_s: time_s, *, starts_s: float = 0.0, top: str = "", offset: str = ""
) -> Path:
    """A press as a video of 10 Hz and a table of 40 Hz on a clock of its own."""
    images = [pressed(force, number) for number, force in enumerate(FORCES_N)]
    video(folder / "press.mkv", images, [starts_s + each for each in TIMES_S])
    video(folder / "free.mkv", [untouched(90 + each) for each in range(6)], TIMES_S[:6])
    dense = np.arange(0, 1.9001, 0.025)
    rows = [{"t": f"{clock(each):.4f}", "f": f"{np.interp(each, TIMES_S, FORCES_N):.4f}"} for each in dense]
    write_csv(folder / "force.csv", rows)
    lines = ['frames = "press.mkv"', 'labels = "force.csv"', 'untouched = "free.mkv"', offset]
    return describe(folder, *lines, top=['columns = {time_s = "t", force_n = "f"}'])


def looked(path: Path) -> Inspection:
    return inspect_real(load_real(path))


def forces(path: Path, out: Path) -> list[float]:
    write_real(load_real(path), out)
    return open_frames(out, ("force_n", "is_reference")).column("force_n")[6:, 2].tolist()


def test_classes_are_counted_over_frames_and_not_over_rows(tmp_path: Path):
    [one] = looked(recording(tmp_path)).recordings
    assert (one.references, one.samples, one.unlabelled) == (6, 20, 0)
    assert one.classes == {"Clear": 0, "Near": 0, "Contact": 8, "Light": 0, "unscored": 12}
    assert (one.frames_s, one.labels_s) == ((0.0, 1.9), (0.0, 1.9))


@pytest.mark.parametrize(
    ("clock", "said"),
    [
        (lambda time_s: time_s + 1764181390.25, "from 1764181390.25 to 1764181392.15 s; offset_s = 1764181390.25"),
        (lambda time_s: time_s - 30, "rows of labels from -30 to -28.1 s; offset_s = -30"),
        (lambda time_s: 1e6 * (time_s + 5), r"are rows in microseconds\? set scale.time_s = 1e-06"),
    ],
)  # fmt: skip
def test_clocks_without_a_common_time_are_an_error(tmp_path: Path, clock, said: str):
    with pytest.raises(ConfigError, match=rf"no frame has labels: frames are from 0 to 1.9 s, .*{said}"):
        looked(recording(tmp_path, clock))


def test_offset_that_the_error_names_mends_it(tmp_path: Path):
    path = recording(tmp_path, lambda time_s: time_s + 1764181390.25, offset="offset_s = 1764181390.25")
    assert forces(path, tmp_path / "set") == pytest.approx(FORCES_N, abs=0.01)


@pytest.mark.parametrize(
    ("clock", "unlabelled", "said"),
    [
        (lambda time_s: time_s + 1, 9, "rows of labels from 1 to 2.9 s"),
        (lambda time_s: 1000 * time_s, 18, r"from 0 to 1900 s; are rows in ms\? set scale.time_s = 0.001"),
    ],
)
def test_frames_without_labels_are_counted_and_both_spans_told(tmp_path: Path, clock, unlabelled: int, said: str):
    found = looked(recording(tmp_path, clock))
    assert found.recordings[0].unlabelled == unlabelled
    [line] = [each for each in found.told if "have no labels" in each]
    assert f"{unlabelled} of 20 frames have no labels: frames are from 0 to 1.9 s" in line
    assert re.search(said, line)


def test_start_of_the_container_counts_and_is_told(tmp_path: Path):
    path = recording(tmp_path, lambda time_s: time_s + 2, starts_s=2.0)
    assert forces(path, tmp_path / "set") == pytest.approx(FORCES_N, abs=0.01)
    assert any("the clock of the video is at 2 s in its first frame" in each for each in looked(path).told)
    mended = recording(tmp_path, starts_s=2.0, offset="offset_s = -2")
    assert forces(mended, tmp_path / "mended") == pytest.approx(FORCES_N, abs=0.01)


def test_dropped_frames_with_right_stamps_shift_nothing_and_are_no_damage(tmp_path: Path, caplog):
    path = recording(tmp_path)
    kept = [0, 1, 2, 7, 10, 13, 14, 19]
    video(tmp_path / "press.mkv", [pressed(FORCES_N[each], each) for each in kept], [TIMES_S[each] for each in kept])
    assert forces(path, tmp_path / "set") == pytest.approx([FORCES_N[each] for each in kept], abs=0.01)
    list(read_source(tmp_path / "press.mkv"))
    assert looked(path).told == []
    assert not caplog.records


def test_video_that_ends_early_is_told_by_import_as_by_detect(tmp_path: Path, caplog):
    path = recording(tmp_path)
    content = (tmp_path / "press.mkv").read_bytes()
    (tmp_path / "press.mkv").write_bytes(content[: 2 * len(content) // 3])
    lines = [each for each in looked(path).told if "the rest is damaged or missing" in each]
    assert len(lines) == 1
    list(read_source(tmp_path / "press.mkv"))
    assert lines[0].removeprefix("recordings[0]: ") in caplog.text
