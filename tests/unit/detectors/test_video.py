import contextlib
import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest

from detectors.conftest import grid_frame, light_frame, near_frame
from magicsim.detectors import DetectorProfile, detect_all, detect_sources, fuse, stream_sources
from magicsim.detectors import frame as frames
from magicsim.detectors import video as module
from magicsim.detectors.source import read_source
from magicsim.detectors.video import open_video, read_camera
from magicsim.errors import ConfigError, FrameError

SCENE = [grid_frame(), near_frame(), light_frame()]


def test_lossless_video_gives_the_frames_that_were_written(tmp_path, write_video):
    found = [each.image for each in read_source(write_video(tmp_path / "a.avi", SCENE))]
    assert len(found) == 3
    assert all(np.array_equal(one, other) for one, other in zip(found, SCENE, strict=True))
    assert all(frame.flags["C_CONTIGUOUS"] for frame in found)


def test_motion_jpeg_keeps_red_and_blue_apart(tmp_path, write_video):
    flat = np.full((48, 64, 3), (180, 90, 30), dtype=np.uint8)
    (found,) = read_source(write_video(tmp_path / "a.avi", [flat], codec="MJPG"))
    assert np.abs(found.image.astype(int) - flat).max() < 12


def test_verdicts_of_a_video_equal_those_of_its_frames(tmp_path, write_video):
    rest = write_video(tmp_path / "rest.avi", [grid_frame()] * 30)
    scene = write_video(tmp_path / "scene.mkv", SCENE)
    profile = DetectorProfile()
    expected = detect_all(SCENE, fuse([grid_frame()] * 30, profile), profile)
    found = detect_sources(scene, rest, profile)
    assert [each.source for each in found] == ["scene.mkv#0", "scene.mkv#1", "scene.mkv#2"]
    assert [replace(each, source=None) for each in found] == expected, "but for `weak`, which frames at rest tell"
    assert detect_sources(scene, rest, profile, frames=2) == found[:2]


@pytest.mark.parametrize("content", [b"", b"hello", b"RIFF\x00\x00\x00\x00AVI LIST"])
def test_file_that_is_no_video_is_one_line_and_prints_nothing(tmp_path, capfd, content):
    path = tmp_path / "a.avi"
    path.write_bytes(content)
    with pytest.raises(FrameError, match=r"a\.avi' cannot be decoded"):
        open_video(path)
    assert capfd.readouterr().err == ""


def test_video_that_breaks_off_gives_what_is_whole_and_warns(tmp_path, write_video, caplog):
    noise = [np.random.default_rng(k).integers(0, 255, (64, 64, 3), dtype=np.uint8) for k in range(6)]
    path = write_video(tmp_path / "a.avi", noise, codec="HFYU")
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    found = [each.image for each in read_source(path)]
    assert 0 < len(found) < 6
    assert all(np.array_equal(one, other) for one, other in zip(found, noise, strict=False))
    assert f"gave {len(found)} of 6 frames" in caplog.text


class Camera:
    """Stands in for `cv2.VideoCapture` of a device."""

    opened: tuple[object, ...] = ()
    active = 0

    def __init__(self, source: object, frames: int = 1000):
        assert Camera.active == 0, "a camera is opened by one reader at a time"
        Camera.opened = (*Camera.opened, source)
        Camera.active += 1
        self.left = frames

    def isOpened(self) -> bool:
        return True

    def read(self) -> tuple[bool, np.ndarray | None]:
        self.left -= 1
        return (True, grid_frame()[..., ::-1]) if self.left >= 0 else (False, None)

    def release(self) -> None:
        Camera.active -= 1


@pytest.fixture
def camera(monkeypatch):
    monkeypatch.setattr(Camera, "opened", ())
    monkeypatch.setattr(Camera, "active", 0)
    monkeypatch.setattr(module.cv2, "VideoCapture", Camera)
    return Camera


def test_one_camera_gives_the_references_and_then_the_frames(camera):
    found = detect_sources("3", "3", frames=4)
    assert [each.source for each in found] == [f"camera 3#{number}" for number in range(4)]
    assert {each.similarity for each in found} == {1.0}
    assert camera.opened == (3, 3)
    assert camera.active == 0


def test_camera_is_released_when_the_reader_stops(camera):
    with contextlib.closing(stream_sources("0", "1")) as verdicts:
        assert next(verdicts).source == "camera 0#0"
        assert camera.active == 1
    assert camera.active == 0


def test_camera_that_stops_is_an_error(camera, monkeypatch):
    monkeypatch.setattr(module.cv2, "VideoCapture", lambda source: Camera(source, frames=2))
    frames = read_camera(0)
    assert len([next(frames), next(frames)]) == 2
    with pytest.raises(FrameError, match="camera 0 gave no more frames after 2"):
        next(frames)
    assert camera.active == 0


def test_camera_that_is_not_there_is_one_line_and_prints_nothing(capfd):
    with pytest.raises(FrameError, match="camera 9876 cannot be opened"):
        next(read_camera(9876))
    assert capfd.readouterr().err == ""


def test_a_camera_needs_a_number_of_frames_for_a_list():
    with pytest.raises(ConfigError, match="frames is missing: camera 0"):
        detect_sources("0", "1")


@pytest.mark.parametrize("frames", [0, -1])
def test_number_of_frames_must_be_positive(tmp_path, frames):
    with pytest.raises(ConfigError, match=f"frames = {frames} is not allowed"):
        detect_sources(tmp_path, tmp_path, frames=frames)


def test_log_level_of_opencv_is_left_as_it_was():
    before = cv2.utils.logging.getLogLevel()
    with module.quiet_opencv():
        assert cv2.utils.logging.getLogLevel() == cv2.utils.logging.LOG_LEVEL_SILENT
    assert cv2.utils.logging.getLogLevel() == before


def test_video_of_huge_frames_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 15, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    assert next(open_video(path)).read().shape == (48, 64, 3)
    monkeypatch.setattr(frames, "MAX_PIXELS", 1000)
    with pytest.raises(FrameError, match="has 64 x 48 pixels"):
        open_video(path)


def turn_track(path, degrees):
    """Writes a turn into the track header of an MP4: a matrix of 16.16 numbers (ISO 14496-12, 8.3.2)."""
    content, one = bytearray(path.read_bytes()), 0x10000
    cosine, sine = {90: (0, one), 180: (-one, 0), 270: (0, -one)}[degrees]
    at = content.find(b"tkhd") + 44
    struct.pack_into(">4i", content, at, cosine, sine, 0, -sine)
    struct.pack_into(">i", content, at + 16, cosine)
    path.write_bytes(content)


@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_frames_are_turned_as_the_track_says_and_it_is_said(tmp_path, write_video, caplog, degrees):
    image = np.zeros((48, 64, 3), np.uint8)
    image[:24, :16] = (220, 40, 20)
    path = write_video(tmp_path / "a.mp4", [image], codec="mp4v")
    turn_track(path, degrees)
    [frame] = read_source(path)
    assert np.abs(frame.image.astype(int) - np.rot90(image, -degrees // 90)).mean() < 12
    assert f"'a.mp4': frames are turned by {degrees} degrees" in caplog.text


@pytest.mark.parametrize(("name", "codec"), [("a.avi", "MJPG"), ("a.mp4", "mp4v"), ("a.avi", "XVID")])
def test_codec_that_loses_detail_is_named_before_the_first_frame(tmp_path, write_video, caplog, name, codec):
    frames = open_video(write_video(tmp_path / name, SCENE, codec=codec))
    assert "which loses detail unless it is told not to: frames of something near may be judged Touched" in caplog.text
    frames.close()


def test_lossless_video_has_no_remark(tmp_path, write_video, caplog):
    list(read_source(write_video(tmp_path / "a.mkv", SCENE)))
    assert not caplog.records


@pytest.mark.parametrize(
    ("change", "ways"),
    [
        (lambda image: image[::-1, ::-1], "turned by 180 degrees"),
        (lambda image: image[:, ::-1], "mirrored"),
        (lambda image: image[..., ::-1], "with red and blue exchanged"),
    ],
)
def test_frames_that_are_turned_against_their_references_are_told(tmp_path, save, caplog, change, ways):
    rows, columns = np.mgrid[0:48, 0:36]
    image = np.stack([10 + 4 * columns, 10 + 4 * rows, 90 - 2 * columns], 2).astype(np.uint8)
    image[:20, :8] = (10, 200, 40)
    for index in range(30):
        save(tmp_path / "rest" / f"{index:02}.png", image)
    save(tmp_path / "now.png", np.ascontiguousarray(change(image)))
    detect_sources(tmp_path / "now.png", tmp_path / "rest", "published")
    assert f"frames look like their references only when they are {ways}: " in caplog.text
