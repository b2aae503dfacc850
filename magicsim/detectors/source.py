"""Frames from a source outside: an image file or a folder of images."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.png_check import is_damaged_png
from magicsim.errors import ConfigError, FrameError

IMAGE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".ppm", ".tif", ".tiff", ".webp")
"""File name endings that are read as images, in any case."""

SourceKind = Literal["image", "folder"]
"""What a source can be."""

_COLOUR_CONVERSIONS = {3: cv2.COLOR_BGR2RGB, 4: cv2.COLOR_BGRA2RGB}
"""To RGB from what OpenCV reads, by number of channels; opacity is dropped."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceFrame:
    """One frame and where it came from."""

    name: str
    """File name."""
    image: Frame
    """RGB image, shape (rows, columns, 3)."""


def source_kind(source: str | Path) -> SourceKind:
    """What the source is.

    Raises:
        ConfigError: It does not exist, or is a file that is not an image.
    """
    path = Path(source).expanduser()
    expected = f"an image ({', '.join(IMAGE_SUFFIXES)}) or a folder of images"
    if path.is_dir():
        return "folder"
    if not path.is_file():
        msg = f"source '{source}' does not exist; give {expected}"
        raise ConfigError(msg)
    if path.suffix.lower() not in IMAGE_SUFFIXES:
        msg = f"source '{source}' is not an image; give {expected}"
        raise ConfigError(msg)
    return "image"


def read_source(source: str | Path) -> Iterator[SourceFrame]:
    """Frames of a source, one at a time; those of a folder in the order of their names.

    Raises:
        ConfigError: The source does not exist, is of no known kind or holds no image.
        FrameError: An image cannot be read; raised when its turn comes.
    """
    return _READERS[source_kind(source)](Path(source).expanduser())


def read_image(path: str | Path) -> Frame:
    """Read an image file as RGB, shape (rows, columns, 3), without rotating it by its metadata.

    Raises:
        FrameError: The file is missing, cannot be decoded, or does not hold 8-bit colour.
    """
    try:
        content = Path(path).read_bytes()
        usable = bool(content) and not is_damaged_png(content)
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED) if usable else None
    except OSError as error:
        msg = f"image '{path}' cannot be read: {error.strerror}"
        raise FrameError(msg) from error
    except cv2.error:
        decoded = None
    if decoded is None:
        msg = f"image '{path}' cannot be decoded; must be a whole image file ({', '.join(IMAGE_SUFFIXES)})"
        raise FrameError(msg)
    channels = decoded.shape[2] if decoded.ndim > len(("rows", "columns")) else 1
    if channels not in _COLOUR_CONVERSIONS:
        msg = f"image '{path}' has {channels} channel(s); must be colour with 3 (RGB)"
        raise FrameError(msg)
    try:
        return check_frame(_to_rgb(decoded))
    except FrameError as error:
        msg = f"image '{path}': {error}"
        raise FrameError(msg) from error


def _to_rgb(decoded: np.ndarray) -> np.ndarray:
    """Reverse OpenCV's BGR or BGRA, for any number type."""
    return decoded[:, :, 2::-1]


def _read_image_file(path: Path) -> Iterator[SourceFrame]:
    return iter([SourceFrame(name=path.name, image=read_image(path))])


def _read_folder(path: Path) -> Iterator[SourceFrame]:
    files = sorted(each for each in path.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES and each.is_file())
    if not files:
        msg = f"source folder '{path}' holds no image ({', '.join(IMAGE_SUFFIXES)})"
        raise ConfigError(msg)
    return (SourceFrame(name=each.name, image=read_image(each)) for each in files)


_READERS: dict[SourceKind, Callable[[Path], Iterator[SourceFrame]]] = {
    "image": _read_image_file,
    "folder": _read_folder,
}
"""The reader of each kind; a new kind of source is one entry here and one line in `source_kind`."""
