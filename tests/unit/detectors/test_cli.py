import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from magicsim.detectors.__main__ import main

from .conftest import grid_frame, light_frame, near_frame


@pytest.fixture
def folders(tmp_path, save):
    """A folder of 30 references and one of three frames to judge."""
    for index in range(30):
        save(tmp_path / "rest" / f"{index:02}.png", grid_frame())
    for name, frame in (("a", grid_frame()), ("b", near_frame()), ("c", light_frame())):
        save(tmp_path / "frames" / f"{name}.png", frame)
    (tmp_path / "empty").mkdir()
    return tmp_path


def run(folders, capsys, source, *options, reference="rest"):
    status = main([str(folders / source), "--reference", str(folders / reference), *options])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_json_holds_one_row_for_each_frame(folders, capsys):
    status, out, err = run(folders, capsys, "frames", "--profile", "published", "--json")
    assert (status, err) == (0, "")
    rows = json.loads(out)["frames"]
    assert [row["source"] for row in rows] == ["a.png", "b.png", "c.png"]
    assert [row["proximity"] for row in rows] == ["Normal", "Approaching", "Noise"]
    assert rows[2]["combined"] == "Unknown"
    assert rows[0]["similarity"] == 1.0


def test_table_has_a_heading_and_one_line_for_each_frame(folders, capsys):
    status, out, _ = run(folders, capsys, "frames/a.png")
    heading, line = out.splitlines()
    assert status == 0
    assert heading.split()[0] == "source"
    assert line.split()[0] == "a.png"
    assert line.split()[-2:] == ["Untouched", "-"]  # not weak


def make_bad(folders):
    rest = grid_frame()
    float_image = rest.astype(np.float32)
    float_image[0, 0, 0] = np.nan
    for name, image in {
        "small.png": rest[:-1],
        "grey.png": rest[..., 0],
        "deep.png": rest.astype(np.uint16) * 200,
        "nan.tiff": float_image,
    }.items():
        cv2.imwrite(str(folders / name), image)
    content = (folders / "frames" / "a.png").read_bytes()
    (folders / "damaged.png").write_bytes(content[: len(content) // 2])
    (folders / "zero.png").write_bytes(b"")
    (folders / "notes.txt").write_text("x")
    (folders / "bad.toml").write_text("tau_x = 1")


@pytest.mark.parametrize(
    ("source", "options", "named"),
    [
        ("none", (), "none' does not exist"),
        ("empty", (), "holds no image"),
        ("notes.txt", (), "is neither an image nor a video"),
        ("damaged.png", (), "damaged.png' cannot be decoded"),
        ("zero.png", (), "zero.png' cannot be decoded"),
        ("small.png", (), "image 'small.png': frame has shape (47, 36, 3); must be (48, 36, 3)"),
        ("grey.png", (), "1 channel(s)"),
        ("deep.png", (), "uint16"),
        ("nan.tiff", (), "1 NaN or infinite values"),
        ("frames", ("--profile", "nope"), "unknown profile 'nope'"),
        ("frames", ("--profile", "{folders}/bad.toml"), "'tau_x'"),
        ("frames", ("--jsn",), "--jsn"),
    ],
)
def test_wrong_input_is_one_line_and_exit_2(folders, capsys, source, options, named):
    make_bad(folders)
    filled = [option.format(folders=folders) for option in options]
    status, out, err = run(folders, capsys, source, *filled)
    assert status == 2
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err


@pytest.mark.parametrize(
    ("reference", "named"),
    [
        ("empty", "holds no image"),
        ("frames/a.png", "1 reference frame(s) are too few"),
        ("none", "not exist"),
    ],
)
def test_wrong_reference_is_one_line_and_exit_2(folders, capsys, reference, named):
    status, _, err = run(folders, capsys, "frames", reference=reference)
    assert status == 2
    assert named in err
    assert err.count("\n") == 1


def test_reference_of_another_size_is_named(folders, capsys, save):
    save(folders / "rest" / "07.png", grid_frame()[:-1])
    status, _, err = run(folders, capsys, "frames")
    assert status == 2
    assert "image '07.png'" in err


def test_few_reference_frames_are_warned_about(folders, capsys, caplog):
    status, _, _ = run(folders, capsys, "frames", reference="frames")
    assert status == 0
    assert "3 reference frames instead of 30" in caplog.text


def test_module_runs_as_a_command_and_keeps_stdout_for_json(folders):
    done = subprocess.run(
        [
            *(sys.executable, "-m", "magicsim.detectors", str(folders / "frames")),
            *("--reference", str(folders / "rest"), "--json"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert len(json.loads(done.stdout)["frames"]) == 3


def test_missing_arguments_exit_2_in_one_line():
    done = subprocess.run([sys.executable, "-m", "magicsim.detectors"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


def test_grasp_adds_stage_and_slip_to_every_frame(folders, capsys, save):
    for index in range(6):
        save(folders / "run" / f"{index}.png", near_frame(index))
    status, out, _ = run(folders, capsys, "run", "--grasp", "--json")
    rows = json.loads(out)["frames"]
    assert status == 0
    assert [row["stage"] for row in rows] == [*["Waiting"] * 4, "Closing", "Closing"]
    assert [row["slip"] for row in rows] == [False] * 6
    status, out, _ = run(folders, capsys, "run", "--grasp")
    assert out.splitlines()[0].split()[-1] == "stage"
    assert out.splitlines()[-1].split()[-1] == "Closing"


def test_number_of_frames_is_a_limit(folders, capsys):
    _, out, _ = run(folders, capsys, "frames", "--frames", "2", "--json")
    assert len(json.loads(out)["frames"]) == 2


def test_video_is_a_source(folders, capsys, write_video):
    write_video(folders / "clip.avi", [grid_frame(), near_frame()])
    status, out, _ = run(folders, capsys, "clip.avi", "--json")
    assert status == 0
    assert [row["proximity"] for row in json.loads(out)["frames"]] == ["Normal", "Approaching"]


def test_camera_without_frames_cannot_be_json(capsys):
    assert main(["0", "--reference", "0", "--json"]) == 2
    assert "frames is missing" in capsys.readouterr().err


def test_camera_is_judged_line_by_line_until_it_is_interrupted(folders, capsys, monkeypatch):
    def endless(_: int):
        yield grid_frame()
        yield near_frame()
        raise KeyboardInterrupt

    monkeypatch.setattr("magicsim.detectors.source.read_camera", endless)
    assert main(["0", "--reference", str(folders / "rest")]) == 130
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:2] for line in lines] == [["source", "entropy"], ["camera", "0#0"], ["camera", "0#1"]]


def test_slip_is_marked_in_its_frame(folders, capsys, save):
    """Approach, lines that vanish under a touch, and lines that are all back."""
    pressed = near_frame()
    pressed[16:] = 80 + np.random.default_rng(1).integers(0, 60, pressed[16:].shape)
    for index, frame in enumerate([*[near_frame()] * 5, *[pressed] * 6, near_frame(), grid_frame()]):
        save(folders / "run" / f"{index:02}.png", frame)
    (folders / "mine.toml").write_text("tau_g = 0.4\ntau_c = 0.95\n")
    _, out, _ = run(folders, capsys, "run", "--grasp", "--json", "--profile", str(folders / "mine.toml"))
    rows = json.loads(out)["frames"]
    assert [number for number, row in enumerate(rows) if row["slip"]] == [11]
    assert [row["stage"] for row in rows[9:]] == ["Transporting", "Transporting", "Slipped", "Returning"]


def test_camera_that_is_not_there_leaves_no_heading(folders, capsys):
    assert main(["9876", "--reference", str(folders / "rest")]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "camera 9876 cannot be opened" in captured.err
