from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.camera.camera import Camera
from magicsim.errors import ConfigError, FrameError
from magicsim.fit.observation import observe, read_observation

CAMERA = Camera(columns=24, rows=32)


def frames(count: int, value: int = 80) -> list[np.ndarray]:
    return [np.full((32, 24, 3), value + number, np.uint8) for number in range(count)]


def test_even_and_odd_frames_are_averaged_apart():
    seen = observe(frames(4), CAMERA)
    assert (seen.even.mean(), seen.odd.mean(), seen.mean.mean(), seen.count) == (81, 82, 81.5, 4)
    alone = observe(frames(1), CAMERA)
    assert (alone.even == alone.odd).all()


def test_frames_of_another_size_are_refused():
    with pytest.raises(FrameError, match=r"has 32 rows and 24 columns, the rig's camera 320 and 240; set rig\.camera"):
        observe(frames(2), Camera(), source="mine")


def test_saturated_frames_are_refused():
    with pytest.raises(FrameError, match=r"mine: 100\.0 % of the pixels are saturated; at most 1 % are allowed"):
        observe(frames(1, 255), CAMERA, source="mine")


def test_folder_is_read_as_rgb(tmp_path: Path):
    image = np.zeros((32, 24, 3), np.uint8)
    image[..., 0] = 90
    assert cv2.imwrite(str(tmp_path / "0.png"), image[..., ::-1])
    assert read_observation(tmp_path, CAMERA, frame=2).mean[0, 0].tolist() == [90, 0, 0]


def test_camera_is_no_recording():
    with pytest.raises(ConfigError, match="'0' is a camera; give recorded images"):
        read_observation("0", CAMERA)


def test_references_that_are_none_are_told_and_states_of_a_scene_are_not(caplog: pytest.LogCaptureFixture):
    black = [np.zeros((32, 24, 3), np.uint8), *frames(5)]
    observe(black, CAMERA, source="mine")
    assert "mine: reference frames 0 are black" in caplog.text
    caplog.clear()
    observe(frames(6), CAMERA, frame=3)
    assert caplog.text == ""
