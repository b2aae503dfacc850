from pathlib import Path

import cv2

from magicsim.config.presets import preset_names

from .conftest import Shell
from .images import write_frames


def test_detect_prints_one_verdict_a_frame(shell: Shell, tmp_path: Path):
    reference, source = write_frames(tmp_path / "rest", 30), write_frames(tmp_path / "now", 2)
    found = shell.json("detect", source, "--reference", reference, "--profile", "published")
    assert list(found) == ["frames"]
    assert len(found["frames"]) == 2
    keys = {
        "entropy",
        "correlation",
        "similarity",
        "p_approach",
        "p_noise",
        "p_touch",
        "proximity",
        "contact",
        "combined",
        "weak",
    }
    assert keys <= set(found["frames"][0])
    assert found["frames"][0]["proximity"] == "Normal"
    assert found["frames"][0]["contact"] == "Untouched"


def test_image_of_size_zero_is_one_line_that_names_it(shell: Shell, tmp_path: Path):
    reference = write_frames(tmp_path / "rest", 30)
    (tmp_path / "empty.png").touch()
    assert "empty.png" in shell.refusal("detect", "empty.png", "--reference", reference)


def test_reference_of_another_size_is_one_line_with_both_sizes(shell: Shell, tmp_path: Path):
    reference, source = write_frames(tmp_path / "rest", 30), write_frames(tmp_path / "now", 1, rows=40, columns=30)
    message = shell.refusal("detect", source, "--reference", reference)
    assert "40" in message
    assert "32" in message


def test_folder_without_images_is_one_line(shell: Shell, tmp_path: Path):
    (tmp_path / "empty").mkdir()
    assert "empty" in shell.refusal("detect", "empty", "--reference", "empty")


def test_unknown_profile_lists_the_choices(shell: Shell, tmp_path: Path):
    frames = write_frames(tmp_path / "rest", 30)
    message = shell.refusal("detect", frames, "--reference", frames, "--profile", "publishd")
    assert "did you mean 'published'" in message
    assert all(name in message for name in preset_names("profile"))


def test_video_is_judged_up_to_a_number_of_frames_with_the_stage_of_a_grasp(shell: Shell, tmp_path: Path):
    reference = write_frames(tmp_path / "rest", 30)
    writer = cv2.VideoWriter(str(tmp_path / "clip.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 15, (24, 32))
    for _ in range(3):
        writer.write(cv2.imread(str(reference / "000.png")))
    writer.release()
    found = shell.json("detect", "clip.avi", "--reference", reference, "--frames", "2", "--grasp")["frames"]
    assert [(row["source"], row["stage"], row["slip"]) for row in found] == [
        ("clip.avi#0", "Waiting", False),
        ("clip.avi#1", "Waiting", False),
    ]
    assert {row["similarity"] for row in found} == {1.0}


def test_camera_that_is_not_there_is_one_line(shell: Shell, tmp_path: Path):
    reference = write_frames(tmp_path / "rest", 30)
    assert "camera 9876 cannot be opened" in shell.refusal("detect", "9876", "--reference", reference, "--frames", "1")


def test_video_that_is_damaged_is_one_line(shell: Shell, tmp_path: Path):
    reference = write_frames(tmp_path / "rest", 30)
    (tmp_path / "clip.mp4").write_bytes(b"hello")
    assert "clip.mp4' cannot be decoded" in shell.refusal("detect", "clip.mp4", "--reference", reference)
