"""Frames come in the order in which they were taken, by times or by numbers in names, or are refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.dataset.frames import open_frames
from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.inspection import inspect_real
from magicsim.dataset.real.writing import write_real
from magicsim.errors import ConfigError

from .drawn import describe, pressed, save, write_csv

FORCES_N = [0.0] * 9 + [0.4, 0.8, 1.0]
NUMBERS = list(range(len(FORCES_N)))
TIMED = 'columns = {time_s = "t", force_n = "f"}'
PLAIN = 'columns = {force_n = "f"}'


@pytest.fixture(autouse=True)
def _kept(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))


def recording(folder: Path, order: list[int], top: str, *, times=lambda number: 0.1 * number) -> Path:
    """Images `frame_0.png` to `frame_11.png`, of which the last three are pressed, and a table in some order."""
    for number, force in enumerate(FORCES_N):
        save(folder / "images" / f"frame_{number}.png", pressed(force, number))
    rows = [{"image_name": f"frame_{each}.png", "t": round(times(each), 3), "f": FORCES_N[each]} for each in order]
    write_csv(folder / "labels.csv", rows)
    return describe(folder, 'frames = "images"', 'labels = "labels.csv"', "untouched_first = 9", top=[top])


@pytest.mark.parametrize("top", [TIMED, PLAIN])
@pytest.mark.parametrize("order", [sorted(NUMBERS, key=str), NUMBERS[::-1]])
def test_rows_in_the_order_of_texts_or_newest_first_are_put_in_order_and_it_is_said(tmp_path: Path, top, order):
    summary = write_real(load_real(recording(tmp_path, order, top)), tmp_path / "set")
    frames = open_frames(tmp_path / "set", ("image", "force_n", "is_reference"))
    assert frames.column("force_n")[:, 2].tolist() == FORCES_N
    assert np.array_equal(frames[11]["image"], pressed(1.0, 11))
    assert any("rows of 'labels.csv' are put in the order of" in line for line in summary.told)


def test_clock_that_was_set_back_is_refused_with_its_line(tmp_path: Path):
    path = recording(tmp_path, NUMBERS, TIMED, times=lambda number: 0.1 * number - (0.45 if number > 5 else 0))
    with pytest.raises(ConfigError, match=r"labels.csv, line 8: time_s falls; must rise .* name columns.episode"):
        inspect_real(load_real(path))


def test_clock_may_begin_anew_in_every_episode(tmp_path: Path):
    path = recording(tmp_path, NUMBERS, 'columns = {time_s = "t", force_n = "f", episode = "e"}')
    rows = [
        {"image_name": f"frame_{each}.png", "t": 0.1 * (each % 6), "f": FORCES_N[each], "e": "ab"[each // 6]}
        for each in NUMBERS
    ]
    write_csv(tmp_path / "labels.csv", rows)
    assert inspect_real(load_real(path)).told == []


def test_rows_in_no_order_of_names_stay_and_it_is_said(tmp_path: Path):
    order = [0, 3, 1, 2, *range(4, 12)]
    told = inspect_real(load_real(recording(tmp_path, order, PLAIN))).told
    assert any(
        "in another order than the numbers in the names of their images: theirs is kept" in each for each in told
    )


def test_folder_without_labels_is_in_the_order_of_its_numbers(tmp_path: Path):
    recording(tmp_path, NUMBERS, PLAIN)
    write_real(load_real(describe(tmp_path, 'frames = "images"', "untouched_first = 9")), tmp_path / "set")
    frames = open_frames(tmp_path / "set", ("image", "is_reference"))
    assert all(np.array_equal(frames[each]["image"], pressed(FORCES_N[each], each)) for each in NUMBERS)


def test_image_of_two_rows_is_refused(tmp_path: Path):
    path = recording(tmp_path, [0, 1, 1], PLAIN)
    with pytest.raises(ConfigError, match=r"line 4: image 'frame_1.png' stands in line 3 too; must have one row"):
        inspect_real(load_real(path))


def test_file_of_several_pictures_is_a_recording(tmp_path: Path):
    images = [pressed(force, number)[..., ::-1] for number, force in enumerate(FORCES_N)]
    assert cv2.imwritemulti(str(tmp_path / "press.tif"), images)
    write_csv(tmp_path / "labels.csv", [{"t": 0.1 * each, "f": FORCES_N[each]} for each in NUMBERS])
    lines = ('frames = "press.tif"', 'labels = "labels.csv"', "untouched_first = 9")
    path = describe(tmp_path, *lines, top=[TIMED, "frames_per_second = 10"])
    write_real(load_real(path), tmp_path / "set")
    frames = open_frames(tmp_path / "set", ("image", "force_n", "time_s"))
    assert frames.column("force_n")[:, 2].tolist() == pytest.approx(FORCES_N)
    assert np.array_equal(frames[11]["image"], pressed(1.0, 11))
    with pytest.raises(ConfigError, match="frames_per_second is missing"):
        inspect_real(load_real(describe(tmp_path, *lines, top=[TIMED])))


def test_times_in_milliseconds_are_told(tmp_path: Path):
    path = recording(tmp_path, NUMBERS, TIMED, times=lambda number: 66.7 * number)
    told = inspect_real(load_real(path)).told
    assert any("frames are 66.7 s apart: ms? set scale.time_s = 0.001" in each for each in told)
