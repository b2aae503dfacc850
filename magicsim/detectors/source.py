"""Frames from a source outside: an image file, a folder of images, a video file or a camera."""

import zlib
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from magicsim.config.presets import expanded, is_file, is_folder
from magicsim.conventions import MAX_PIXELS
from magicsim.detectors.frame import Frame, check_frame, check_pixels
from magicsim.detectors.video import VIDEO_SUFFIXES, open_video, quiet_opencv, read_camera
from magicsim.errors import NAME_LENGTH, ConfigError, FrameError, shortened

IMAGE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".ppm", ".tif", ".tiff", ".webp")
"""File name endings that are read as images, in any case."""

MAX_BYTES = 8 * MAX_PIXELS
"""Largest image file: so many pixels of four channels of 16 bit."""

SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""First bytes of every PNG file."""

_LENGTH, _NAME, _SUM = 4, 4, 4

SourceKind = Literal["image", "folder", "video", "camera"]
"""What a source can be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceFrame:
    """One frame and where it came from."""

    name: str
    """File name; that of a video, or `camera` and its index, with `#` and the frame's number from 0."""
    image: Frame
    """RGB image, shape (rows, columns, 3)."""


Frames = Generator[SourceFrame, None, None]
"""Frames one at a time; closing it releases what it reads from."""


def source_kind(source: str | Path) -> SourceKind:
    """What the source is. A whole number is a camera's index, unless a file or folder has that name.

    Raises:
        ConfigError: It does not exist, or is a file of an unknown kind.
    """
    path = expanded(source)
    if is_folder(path):
        return "folder"
    if not is_file(path) and str(source).isascii() and str(source).isdecimal():
        return "camera"
    expected = f"an image ({', '.join(IMAGE_SUFFIXES)}), a folder of images"
    expected += f", a video ({', '.join(VIDEO_SUFFIXES)}) or a camera's index"
    if not is_file(path):
        raise ConfigError(f"source '{shortened(str(source), 2 * NAME_LENGTH)}' does not exist; give {expected}")
    suffix = path.suffix.lower()
    if suffix in IMAGE_SUFFIXES:
        return "image"
    if suffix in VIDEO_SUFFIXES:
        return "video"
    raise ConfigError(f"source '{source}' is neither an image nor a video; give {expected}")


def read_source(source: str | Path) -> Frames:
    """Frames of a source, one at a time; those of a folder in the order of their names, a camera's without end.

    A camera is opened with its first frame and released when the iterator is closed, so that one camera can give the
    references first and the frames to judge afterwards.

    Raises:
        ConfigError: The source does not exist, is of no known kind or holds no image.
        FrameError: An image, a video or a camera cannot be read; raised when its turn comes, for a video at once.
    """
    return _READERS[source_kind(source)](expanded(source))


def read_image(path: str | Path) -> Frame:
    """Read an image file as RGB, shape (rows, columns, 3), without rotating it by its metadata.

    Raises:
        FrameError: The file is missing, cannot be decoded, or does not hold 8-bit colour.
    """
    try:
        decoded = _decoded(Path(path))
    except FrameError:
        raise
    except (OSError, ValueError) as error:
        raise FrameError(f"image '{path}' cannot be read: {getattr(error, 'strerror', None) or error}") from error
    except cv2.error as error:
        if "MAX_IMAGE" in str(error):  # the limit that OpenCV is loaded with, see `magicsim.__init__`
            msg = f"image '{path}' has too many pixels; at most {MAX_PIXELS / 1e6:.0f} million are allowed"
            raise FrameError(msg) from None
        decoded = None
    if decoded is None:
        raise FrameError(f"image '{path}' cannot be decoded; must be a whole image file ({', '.join(IMAGE_SUFFIXES)})")
    channels = decoded.shape[2] if decoded.ndim > len(("rows", "columns")) else 1
    if channels not in {3, 4}:  # opacity is dropped
        raise FrameError(f"image '{path}' has {channels} channel(s); must be colour with 3 (RGB)")
    try:
        return check_frame(decoded[:, :, 2::-1])  # RGB from OpenCV's BGR or BGRA
    except FrameError as error:
        raise FrameError(f"image '{path}': {error}") from error


def _decoded(path: Path) -> np.ndarray | None:
    """Pixels of a file as OpenCV reads it; None where it is no whole image."""
    length = path.stat().st_size
    if length > MAX_BYTES:
        raise FrameError(f"image '{path}' has {length / 1e6:.0f} MB; at most {MAX_BYTES / 1e6:.0f} MB are allowed")
    content = path.read_bytes()
    if not content or is_damaged_png(content):
        return None
    with quiet_opencv():
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if decoded is not None:
        check_pixels(f"image '{path}'", decoded.shape[1], decoded.shape[0])
    return decoded


def is_damaged_png(content: bytes) -> bool:
    """Whether the bytes start as a PNG and then break off or fail a chunk's checksum.

    Walks the chunks (length, name, data, CRC-32 of name and data) up to `IEND`: PNG specification, section 5.
    """
    if not content.startswith(SIGNATURE):
        return False
    at = len(SIGNATURE)
    while at + _LENGTH + _NAME + _SUM <= len(content):
        name_at = at + _LENGTH
        sum_at = name_at + _NAME + int.from_bytes(content[at:name_at])
        body = content[name_at:sum_at]
        if zlib.crc32(body) != int.from_bytes(content[sum_at : sum_at + _SUM]):
            return True
        if body.startswith(b"IEND"):
            return False
        at = sum_at + _SUM
    return True


def _read_folder(path: Path) -> Frames:
    files = sorted(each for each in path.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES and each.is_file())
    if not files:
        raise ConfigError(f"source folder '{path}' holds no image ({', '.join(IMAGE_SUFFIXES)})")
    return _read_files(files)


def _read_files(files: Iterable[Path]) -> Frames:
    return (SourceFrame(name=each.name, image=read_image(each)) for each in files)


def _numbered(name: str, images: Generator[Frame, None, None]) -> Frames:
    with closing(images):
        for number, image in enumerate(images):
            yield SourceFrame(name=f"{name}#{number}", image=image)


_READERS: dict[SourceKind, Callable[[Path], Frames]] = {
    "image": lambda path: _read_files([path]),
    "folder": _read_folder,
    "video": lambda path: _numbered(path.name, open_video(path)),
    "camera": lambda path: _numbered(f"camera {path}", read_camera(int(str(path)))),
}
"""The reader of each kind; a new kind of source is one entry here and one line in `source_kind`."""
