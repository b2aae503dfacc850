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
    for name in ("-1", "1.5", "\u0661", "3000000000", "9" * 5000):
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


def test_numbers_in_names_count_as_numbers_and_it_is_said(tmp_path, save, caplog):
    for index in (1, 2, 10):
        save(tmp_path / f"frame_{index}.png", np.full_like(IMAGE, index))
    assert [frame.image[0, 0, 0] for frame in read_source(tmp_path)] == [1, 2, 10]
    assert "in the order of the numbers in their names, 'frame_2.png' before 'frame_10.png'" in caplog.text


def test_order_of_padded_names_and_of_names_without_numbers_is_that_of_their_text(tmp_path, save, caplog):
    for name in ("b", "a", "x_08", "x_09", "x_10"):
        save(tmp_path / f"{name}.png", IMAGE)
    assert [frame.name for frame in read_source(tmp_path)] == ["a.png", "b.png", "x_08.png", "x_09.png", "x_10.png"]
    assert not caplog.records


def test_order_that_decimal_points_leave_open_is_refused(tmp_path, save):
    for name in ("0.5", "0.25"):
        save(tmp_path / f"{name}.png", IMAGE)
    with pytest.raises(ConfigError, match=r"'0\.5\.png' may come before or after '0\.25\.png'; fill up"):
        list(read_source(tmp_path))


def test_files_of_macos_are_passed_over_with_a_word(tmp_path, save, caplog):
    save(tmp_path / "0.png", IMAGE)
    (tmp_path / "._0.png").write_bytes(b"\x00\x05\x16\x07")
    assert [frame.name for frame in read_source(tmp_path)] == ["0.png"]
    assert "1 file(s) of macOS without a picture are passed over, such as '._0.png'" in caplog.text


PAGES = [np.full_like(IMAGE, index) for index in range(5)]


@pytest.mark.parametrize("suffix", [".tif", ".png", ".webp"])
def test_file_of_several_pictures_is_read_whole(tmp_path, suffix):
    path = tmp_path / f"stack{suffix}"
    if suffix == ".tif":
        assert cv2.imwritemulti(str(path), PAGES)
    else:
        animation = cv2.Animation()
        animation.frames = [np.dstack([each, np.full(each.shape[:2], 255, np.uint8)]) for each in PAGES]
        animation.durations = [50] * len(PAGES)
        options = [cv2.IMWRITE_WEBP_QUALITY, 101] if suffix == ".webp" else []
        assert cv2.imwriteanimation(str(path), animation, options)
    frames = list(read_source(path))
    assert [frame.name for frame in frames] == [f"stack{suffix}#{index}" for index in range(5)]
    assert [int(frame.image.max()) for frame in frames] == [0, 1, 2, 3, 4]
    with pytest.raises(FrameError, match="holds 5 pictures; must hold one here"):
        read_image(path)


def test_second_page_of_a_tiff_that_is_a_small_copy_is_no_frame(tmp_path):
    path = tmp_path / "a.tif"
    assert cv2.imwritemulti(str(path), [IMAGE, IMAGE[:2, :3]])
    content = bytearray(path.read_bytes())
    first = struct.unpack_from("<I", content, 4)[0]
    second = struct.unpack_from("<I", content, first + 2 + 12 * struct.unpack_from("<H", content, first)[0])[0]
    tags = [second + 2 + 12 * number for number in range(struct.unpack_from("<H", content, second)[0])]
    [subfile] = [at for at in tags if struct.unpack_from("<H", content, at)[0] == 254] or [None]
    at = subfile if subfile is not None else tags[0]
    struct.pack_into("<HHII", content, at, 254, 4, 1, 1)
    path.write_bytes(content)
    assert [frame.image.shape for frame in read_source(path)] == [IMAGE.shape]


def with_orientation(path, value):
    """Writes an Exif orientation into a PNG or a JPEG."""
    content = path.read_bytes()
    tiff = struct.pack("<2sHIHHHIHHI", b"II", 42, 8, 1, 0x0112, 3, 1, value, 0, 0)
    if path.suffix == ".jpg":
        body = b"Exif\x00\x00" + tiff
        added, at = b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body, 2
    else:
        body, at = b"eXIf" + tiff, 33
        added = struct.pack(">I", len(tiff)) + body + struct.pack(">I", zlib.crc32(body))
    path.write_bytes(content[:at] + added + content[at:])
    return path


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
@pytest.mark.parametrize(("value", "turns"), [(3, 2), (6, 3), (8, 1)])
def test_picture_is_turned_as_its_exif_says_and_it_is_said_once(tmp_path, save, caplog, suffix, value, turns):
    image = np.zeros((16, 24, 3), np.uint8)
    image[:8, :8] = (250, 30, 10)
    for name in "ab":
        with_orientation(save(tmp_path / f"{name}{suffix}", image), value)
    for frame in read_source(tmp_path):
        assert np.abs(frame.image.astype(int) - np.rot90(image, turns)).mean() < 12
    assert caplog.text.count(f"turned as their Exif orientation {value} says") == 1
    assert caplog.text.count("JPEG, which loses detail") == (suffix == ".jpg")


def test_pictures_one_after_the_other_in_a_ppm_are_refused_and_one_is_read(tmp_path, save):
    path = save(tmp_path / "a.ppm", IMAGE)
    assert [frame.name for frame in read_source(path)] == ["a.ppm"]
    path.write_bytes(3 * path.read_bytes())
    for read in (read_image, lambda each: list(read_source(each))):
        with pytest.raises(FrameError, match="holds 3 pictures"):
            read(path)
