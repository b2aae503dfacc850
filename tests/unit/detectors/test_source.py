import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest

from magicsim.detectors import read_image, read_source
from magicsim.detectors.source import source_kind
from magicsim.errors import ConfigError, FrameError

IMAGE = np.zeros((4, 6, 3), dtype=np.uint8)
IMAGE[..., 0], IMAGE[..., 2] = 200, 30


@pytest.mark.parametrize("suffix", [".png", ".PNG", ".bmp", ".tiff", ".ppm"])
def test_image_is_read_as_rgb(tmp_path, save, suffix):
    assert np.array_equal(read_image(save(tmp_path / f"a{suffix}", IMAGE)), IMAGE)


def test_jpeg_is_read_as_rgb(tmp_path, save):
    found = read_image(save(tmp_path / "a.jpg", IMAGE)).astype(int)
    assert np.abs(found - IMAGE).max() < 10


def test_opacity_is_dropped(tmp_path, save):
    blue_first = np.concatenate([IMAGE[..., ::-1], np.full((4, 6, 1), 9, np.uint8)], axis=2)
    path = save(tmp_path / "a.png", blue_first[..., [3, 2, 1, 0]])  # saved reversed, so BGRA on disk
    assert np.array_equal(read_image(path), IMAGE)


def test_folder_gives_its_images_in_name_order_and_nothing_else(tmp_path, save):
    for index, name in enumerate(["b.png", "a.png", "c.bmp"]):
        save(tmp_path / name, np.full_like(IMAGE, index))
    (tmp_path / "labels.json").write_text("{}")
    (tmp_path / "d.png").mkdir()
    frames = list(read_source(tmp_path))
    assert [frame.name for frame in frames] == ["a.png", "b.png", "c.bmp"]
    assert [frame.image[0, 0, 0] for frame in frames] == [1, 0, 2]


def test_image_file_is_a_source_of_one_frame(tmp_path, save):
    path = save(tmp_path / "a.png", IMAGE)
    assert (source_kind(path), source_kind(tmp_path)) == ("image", "folder")
    assert [frame.name for frame in read_source(str(path))] == ["a.png"]


def test_missing_source_is_named(tmp_path):
    with pytest.raises(ConfigError, match="none' does not exist"):
        read_source(tmp_path / "none")


def test_empty_folder_is_named(tmp_path):
    with pytest.raises(ConfigError, match="holds no image"):
        read_source(tmp_path)


def test_file_that_is_no_image_is_named(tmp_path):
    (tmp_path / "notes.txt").write_text("x")
    with pytest.raises(ConfigError, match=r"notes.txt' is neither an image nor a video; .*\.png"):
        read_source(tmp_path / "notes.txt")


def test_grey_image_is_refused(tmp_path, save):
    with pytest.raises(FrameError, match=r"1 channel\(s\)"):
        read_image(save(tmp_path / "a.png", IMAGE[..., 0]))


@pytest.mark.parametrize(
    ("suffix", "change"),
    [
        (".png", lambda content: content[: len(content) // 2]),
        (".png", lambda content: content[:20] + b"\xff" + content[21:]),
        (".png", lambda content: content[:-9]),
        (".png", lambda content: content[:8]),
        (".jpg", lambda content: content[: len(content) // 2]),
        (".jpg", lambda _: b"hello"),
        (".bmp", lambda _: b""),
    ],
)
def test_damaged_image_is_one_line_and_prints_nothing(tmp_path, save, capfd, suffix, change):
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    path = save(tmp_path / f"a{suffix}", noise)
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(FrameError, match=r"cannot be decoded") as caught:
        read_image(path)
    assert "\n" not in str(caught.value)
    if suffix == ".png":
        assert capfd.readouterr().err == ""


def test_whole_number_is_a_camera_unless_a_file_or_folder_has_that_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert source_kind("0") == source_kind("12") == "camera"
    (tmp_path / "0").mkdir()
    assert source_kind("0") == "folder"
    for name in ("-1", "1.5", "\u0661"):
        with pytest.raises(ConfigError, match="does not exist"):
            source_kind(name)


def test_video_file_is_a_source_of_numbered_frames(tmp_path, write_video):
    path = write_video(tmp_path / "clip.avi", [IMAGE, IMAGE + 20])
    assert source_kind(path) == "video"
    assert [(each.name, each.image[0, 0, 0]) for each in read_source(path)] == [
        ("clip.avi#0", 200),
        ("clip.avi#1", 220),
    ]


def huge_png(side: int) -> bytes:
    """An image of one grey level whose file is small."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


def test_huge_image_is_refused_before_it_is_decoded(tmp_path):
    path = tmp_path / "huge.png"
    path.write_bytes(huge_png(30_000))
    code = f"from magicsim.detectors import read_image\nread_image({str(path)!r})"  # OpenCV is loaded with its limit
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "huge.png' has too many pixels; at most 50 million are allowed" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("suffix", [".bmp", ".jpg", ".png", ".ppm", ".tiff", ".webp"])
@pytest.mark.parametrize("kept", [0, 1, 12, 100])
def test_image_that_breaks_off_is_refused_and_nothing_is_printed(tmp_path, capfd, suffix, kept):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(
        cv2.imencode(suffix, np.random.default_rng(0).integers(0, 255, (37, 53, 3), np.uint8))[1].tobytes()[:kept]
    )
    with pytest.raises(FrameError, match="cannot be decoded; must be a whole image file"):
        read_image(path)
    assert capfd.readouterr() == ("", "")
