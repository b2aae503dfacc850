import io
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from magicsim.detectors import image_header, video
from magicsim.detectors.image_header import image_size
from magicsim.detectors.source import IMAGE_SUFFIXES, read_image
from magicsim.detectors.video import open_video
from magicsim.errors import FrameError

IMAGE = np.random.default_rng(0).integers(0, 255, (37, 53, 3), np.uint8)


@pytest.mark.parametrize("suffix", IMAGE_SUFFIXES)
def test_size_is_that_of_the_decoded_image(tmp_path: Path, suffix: str):
    content = cv2.imencode(suffix, IMAGE)[1].tobytes()
    assert image_size(content) == (53, 37)
    (tmp_path / f"a{suffix}").write_bytes(content)
    assert read_image(tmp_path / f"a{suffix}").shape == (37, 53, 3)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("JPEG", {"progressive": True, "exif": b"Exif\0\0" + b"x" * 20_000}),
        ("WEBP", {"lossless": False}),
        ("WEBP", {"exif": b"Exif\0\0xxxx"}),
        ("TIFF", {"compression": "tiff_deflate"}),
        ("PNG", {"optimize": True}),
    ],
)
def test_other_ways_to_write_a_format_are_understood(kind: str, options: dict[str, object]):
    image = pytest.importorskip("PIL.Image")
    sink = io.BytesIO()
    image.fromarray(IMAGE).save(sink, kind, **options)
    assert image_size(sink.getvalue()) == (53, 37)


@pytest.mark.parametrize("suffix", IMAGE_SUFFIXES)
@pytest.mark.parametrize("kept", [0, 1, 5, 12])
def test_head_that_breaks_off_has_no_size(suffix: str, kept: int):
    assert image_size(cv2.imencode(suffix, IMAGE)[1].tobytes()[:kept]) in {None, (53, 37)}


def huge_png(side: int) -> bytes:
    """An image of one grey level whose file is small."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


def test_huge_image_is_refused_by_its_header(tmp_path: Path):
    path = tmp_path / "huge.png"
    path.write_bytes(huge_png(30_000))
    with pytest.raises(FrameError, match=r"huge\.png' has 30000 x 30000 pixels; at most 50 million are allowed"):
        read_image(path)


def test_video_of_huge_frames_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 15, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    assert next(open_video(path)).shape == (48, 64, 3)
    monkeypatch.setattr(image_header, "MAX_PIXELS", 1000)
    with pytest.raises(FrameError, match="has 64 x 48 pixels"):
        video.open_video(path)
