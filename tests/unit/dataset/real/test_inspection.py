"""What is odd about recorded frames is told with what to set."""

from pathlib import Path

import numpy as np
import pytest

from magicsim.dataset.real.description import load_real
from magicsim.dataset.real.inspection import inspect_real

from .drawn import describe, pressed, public_set, save, untouched, write_csv

FORCES_N = [0.0] * 6 + [0.3, 0.6, 0.0, 0.4]


def told(path: Path, *settings: str) -> list[str]:
    return inspect_real(load_real(path, settings)).told


def test_sound_recording_has_nothing_to_set(tmp_path: Path):
    found = inspect_real(load_real(public_set(tmp_path, FORCES_N)))
    assert found.told == []
    [one] = found.recordings
    assert (one.episodes, one.references, one.samples, one.columns, one.rows) == (1, 7, 3, 80, 60)
    assert one.labels == ["force_n"]
    assert one.classes == {"Clear": 0, "Near": 0, "Contact": 3, "Light": 0, "unscored": 0}


def test_recording_without_references_or_labels_is_told(tmp_path: Path):
    public_set(tmp_path, FORCES_N)
    found = told(describe(tmp_path, 'frames = "images"'))
    assert any("set untouched, untouched_first or untouched_below_n" in line for line in found)
    assert any("recordings[0].labels is missing" in line for line in found)


def test_force_of_the_other_sign_is_told(tmp_path: Path):
    found = told(public_set(tmp_path, FORCES_N), "scale.force_n=[1,1,-1]")
    assert any("set scale.force_n with a negative last factor" in line for line in found)


def test_depth_of_the_other_sign_is_told(tmp_path: Path):
    save(tmp_path / "images" / "0.png", pressed(0.5))
    write_csv(tmp_path / "labels.csv", [{"image_name": "0.png", "z": -0.5}])
    path = describe(tmp_path, 'frames = "images"', 'labels = "labels.csv"', top=['columns = {depth_mm = "z"}'])
    assert any("set scale.depth_mm = -1" in line for line in told(path))


def test_other_exposure_than_the_references_is_told_with_a_gain_that_mends_it(tmp_path: Path):
    for number in range(5):
        save(tmp_path / "free" / f"{number}.png", untouched(number))
        save(tmp_path / "images" / f"{number}.png", np.rint(untouched(number) * 0.7).astype(np.uint8))
    path = describe(tmp_path, 'frames = "images"', 'untouched = "free"')
    [line] = [line for line in told(path) if "times as bright" in line]
    assert "0.70 times as bright" in line
    gain = float(line.rpartition("set gain = ")[2].split()[0])
    mended = describe(tmp_path, 'frames = "images"', 'untouched = "free"', f"gain = {gain}")
    assert not [line for line in told(mended) if "times as bright" in line]


def test_other_white_balance_is_told(tmp_path: Path):
    for number in range(5):
        save(tmp_path / "free" / f"{number}.png", untouched(number))
        save(tmp_path / "images" / f"{number}.png", np.rint(untouched(number) * [0.8, 1, 1]).astype(np.uint8))
    assert any(
        "lock the white balance" in line for line in told(describe(tmp_path, 'frames = "images"', 'untouched = "free"'))
    )


def test_white_frames_are_told(tmp_path: Path):
    save(tmp_path / "images" / "0.png", np.full((60, 80, 3), 255, np.uint8))
    assert any("100 % of the pixels are white" in line for line in told(describe(tmp_path, 'frames = "images"')))


def other(tmp_path: Path) -> Path:
    """A recorded episode of the same drawn sensor, as frames should look."""
    folder = tmp_path / "like"
    rows = []
    for number in range(6):
        save(folder / f"{number}.png", untouched(50 + number))
        rows.append(
            {"file": f"{number}.png", "is_reference": int(number < 5), "gap_mm": "", "force_n": 0, "flashlight": 0}
        )
    write_csv(folder / "truth.csv", rows)
    return folder


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda image: image[::-1, ::-1], "set frames.rotate_deg = 180 and frames.mirror = false"),
        (lambda image: image[:, ::-1], "set frames.rotate_deg = 0 and frames.mirror = true"),
        (np.rot90, "set frames.rotate_deg = 270 and frames.mirror = false"),
        (lambda image: image[..., ::-1], 'set frames.color_order = "bgr"'),
        (lambda image: np.repeat(np.repeat(image, 2, 0), 2, 1), "set frames.size_px = [80, 60]"),
        (lambda image: image // 2, "set rig.camera.exposure_grey = "),
    ],
)
def test_frames_unlike_those_of_another_sensor_are_told_with_what_to_set(tmp_path: Path, change, said: str):
    other(tmp_path)
    for number in range(5):
        save(tmp_path / "images" / f"{number}.png", np.ascontiguousarray(change(untouched(number))))
    path = describe(tmp_path, 'frames = "images"', "untouched_first = 3", top=['like = "like"'])
    assert any(said in line for line in told(path))


def test_what_is_told_of_orientation_and_colours_mends_them_together(tmp_path: Path):
    other(tmp_path)
    for number in range(5):
        changed = np.ascontiguousarray(np.rot90(untouched(number))[:, ::-1, ::-1])
        save(tmp_path / "images" / f"{number}.png", changed)
    path = describe(tmp_path, 'frames = "images"', "untouched_first = 3", top=['like = "like"'])
    found = told(path)
    [turn] = [line for line in found if "frames.rotate_deg" in line]
    settings = [part.replace(" ", "") for part in turn.partition(": set ")[2].split(" and ")]
    assert any("color_order" in line for line in found)
    mended = told(path, *settings, "frames.color_order=bgr")
    assert not [line for line in mended if "frames." in line]
