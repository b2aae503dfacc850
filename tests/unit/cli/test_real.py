"""Recorded frames through the command line: described, looked at, converted, and read by every command that judges."""

from pathlib import Path

import numpy as np
import pytest
from dataset.real.drawn import describe, pressed, public_set, save, untouched, write_csv

from magicsim.camera.camera import Camera
from magicsim.errors import ConfigError, FrameError
from magicsim.fit.observation import read_observation

from .conftest import Shell

FORCES_N = [0.0] * 12 + [0.5, 0.8, 0.0, 1.0, 0.0, 0.6]
CLEAR = 'truth.without_contact="Clear"'


@pytest.fixture
def dataset(tmp_path: Path, shell: Shell, monkeypatch) -> Path:
    """A converted public set; untouched frames beyond the references count as Clear."""
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))
    public_set(tmp_path, FORCES_N)
    path = describe(tmp_path, 'frames = "images"', 'labels = "labels.csv"', "untouched_first = 10")
    done = shell.json("real", path, "--out", tmp_path / "set", "--set", CLEAR)
    assert (done["samples"], done["episodes"], done["told"]) == (18, 1, [])
    return tmp_path / "set"


def test_without_a_folder_frames_are_looked_at(tmp_path: Path, shell: Shell):
    found = shell.json("real", public_set(tmp_path, FORCES_N), "--set", "scale.force_n=[1,1,-1]")
    assert found["recordings"][0]["samples"] == 4
    assert any("scale.force_n" in line for line in found["told"])


def test_detect_reads_a_dataset_with_its_own_references(dataset: Path, shell: Shell):
    frames = shell.json("detect", dataset, "--profile", "published")["frames"]
    assert [each["source"] for each in frames[:2]] == ["episode-0#0", "episode-0#1"]
    similarity = np.array([each["similarity"] for each in frames])
    touched = np.array(FORCES_N[10:]) > 0
    assert similarity[touched].max() < similarity[~touched].min()
    assert len(shell.json("detect", dataset, "--profile", "published", "--frames", "3")["frames"]) == 3


def test_detect_of_anything_else_still_needs_a_reference(tmp_path: Path, shell: Shell):
    public_set(tmp_path, FORCES_N[:2])
    done = shell("detect", tmp_path / "images")
    assert done.code == 2
    assert "--reference is missing" in done.err


def test_evaluate_judges_a_dataset(dataset: Path, shell: Shell, tmp_path: Path):
    found = shell.json("evaluate", "--on", dataset, "--profile", "published", "--out", tmp_path / "page", code=1)
    assert [each["of"] for each in found["collapses"]] == ["Contact", "contact_balanced_accuracy"]
    assert found["confusion"]["contact"]["Clear"]["Untouched"] == 4
    assert sum(found["confusion"]["contact"]["Contact"].values()) == 4
    assert (tmp_path / "page" / "report.html").is_file()


def test_calibrate_fits_a_profile_to_a_dataset(shell: Shell, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MAGICSIM_FRAMES", str(tmp_path / "kept"))
    rows = []
    for number, state in enumerate(["free"] * 12 + ["near", "touch", "lamp"] * 4):
        force = {"touch": 0.9, "near": 0.1}.get(state, 0.0)
        image = untouched(number) // 2 + 100 if state == "lamp" else pressed(force, number)
        save(tmp_path / "images" / f"{number}.png", image.astype(np.uint8))
        rows.append({"image_name": f"{number}.png", "what": state})
    write_csv(tmp_path / "labels.csv", rows)
    path = describe(
        tmp_path, 'frames = "images"', 'labels = "labels.csv"', "untouched_first = 8",
        top=['columns.frame_class = "what"',
             'truth.classes = {free = "Clear", near = "Near", touch = "Contact", lamp = "Light"}'],
    )  # fmt: skip
    assert shell("real", path, "--out", tmp_path / "set").code == 0
    found = shell.json(
        "calibrate", tmp_path / "set", "--out", tmp_path / "mine.toml", "--set", "tau_b=[35,80]",
        "--set", "reference_count=8", "--set", "grid_blur_px=0",
    )  # fmt: skip
    assert found["frames"] == {"Clear": 4, "Near": 4, "Contact": 4, "Light": 4}
    assert found["contact_accuracy"] > 0.8


def test_fit_observes_references_and_the_frames_of_an_episode(dataset: Path):
    camera = Camera(columns=80, rows=60)
    at_rest = read_observation(dataset, camera)
    assert at_rest.count == 10
    assert at_rest.mean == pytest.approx(np.mean([untouched(number) for number in range(10)], 0))
    assert read_observation(f"{dataset}:0", camera, frame=3).count == 8
    with pytest.raises(ConfigError, match="name an episode that shows one state"):
        read_observation(dataset, camera, frame=3)
    with pytest.raises(ConfigError, match=r"unknown episode of .* '7'; available: 0"):
        read_observation(f"{dataset}:7", camera, frame=3)
    with pytest.raises(FrameError, match=r"set rig.camera.rows and rig.camera.columns"):
        read_observation(dataset, Camera(columns=40, rows=30))


def test_what_is_wrong_is_one_line(tmp_path: Path, shell: Shell):
    for settings, said in (
        (["frames.size_px=[4,4]"], "frames.size_px"),
        (["columns.depth_mm=deep"], "unknown column of columns.depth_mm 'deep'"),
        (["frames.crop_px=[0,0,400,8]"], "frames.crop_px = [0, 0, 400, 8] is not allowed"),
    ):
        done = shell(
            "real", public_set(tmp_path, FORCES_N[:3]), *(word for each in settings for word in ("--set", each))
        )
        assert done.code == 2
        assert said in done.err
        assert done.err.count("\n") == 1
