"""Frames from a source outside: an image file, a folder of images, a video file or a camera.

The one reader of frames: detectors, recordings and their references see a file alike.
"""

import logging
import re
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from magicsim.config.presets import expanded, is_file, is_folder
from magicsim.detectors.frame import Frame
from magicsim.detectors.picture import IMAGE_SUFFIXES, once, read_pictures
from magicsim.detectors.video import VIDEO_SUFFIXES, Remark, Shot, Shots, open_video, read_camera
from magicsim.errors import NAME_LENGTH, ConfigError, shortened

SourceKind = Literal["image", "folder", "video", "camera"]
"""What a source can be."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceFrame:
    """One frame and where it came from."""

    name: str
    """File name; that of a video or a file of several pictures, or `camera` and its index, with `#` and the frame's
    number from 0."""
    image: Frame
    """RGB image, shape (rows, columns, 3)."""


Frames = Generator[SourceFrame, None, None]
"""Frames one at a time; closing it releases what it reads from."""


def source_kind(source: str | Path) -> SourceKind:
    """What the source is. A whole number is a camera's index, unless a file or folder has that name.

    `ConfigError` where it does not exist, or is a file of an unknown kind.
    """
    path = expanded(source)
    if is_folder(path):
        return "folder"
    if not is_file(path) and _CAMERA.fullmatch(str(source)):
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


def read_source(source: str | Path, remark: Remark | None = None) -> Frames:
    """Frames of a source, one at a time; a camera's without end.

    Those of a folder come by the numbers in their names, all pictures of a file of several one after the other. A
    camera is opened with its first frame and released when the iterator is closed, so that one camera can give the
    references first and the frames to judge afterwards.

    Args:
        source: Image file, folder of images, video file, or index of a camera.
        remark: Hears what was done to frames (turned as their file says, put in order) and what is odd about them
            (a coding that loses detail, a video that ends early); the log by default.

    Raises:
        ConfigError: The source does not exist, is of no known kind, holds no image, or does not tell their order.
        FrameError: An image, a video or a camera cannot be read; raised when its turn comes, for a video at once.
    """
    return _read(open_source(source, remark))


def _read(shots: Shots) -> Frames:
    with closing(shots):
        for each in shots:
            yield SourceFrame(name=each.name, image=each.read())


def open_source(source: str | Path, remark: Remark | None = None) -> Shots:
    """The frames of `read_source`, each decoded when it is asked for; raises the same."""
    kind, path, told = source_kind(source), expanded(source), once(remark or _LOG.warning)
    if kind == "video":
        return open_video(path, told)
    if kind == "camera":
        return _open_camera(int(str(path)))
    return _open_files(image_files(path, told) if kind == "folder" else [path], told)


def _open_files(files: Iterable[Path], remark: Remark) -> Shots:
    for each in files:
        pictures = read_pictures(each, remark)
        for number, read in enumerate(pictures):
            yield Shot(name=each.name if len(pictures) == 1 else f"{each.name}#{number}", read=read)


def _open_camera(index: int) -> Shots:
    with closing(read_camera(index)) as images:
        for number, image in enumerate(images):
            yield Shot(name=f"camera {index}#{number}", read=partial(np.asarray, image))


HIDDEN = "."
"""How the names of files begin that are hidden, such as those in which macOS keeps what other disks cannot (`._`, RFC
1740), and what programs have not finished."""
_NUMBERS = re.compile(r"(\d+)")
_CAMERA = re.compile("[0-9]{1,9}")
"""Index of a camera, which OpenCV takes in 32 bit."""
_DECIMAL = re.compile(r"\d[.,]\d")


def image_files(folder: Path, remark: Remark) -> list[Path]:
    """Images of a folder by the numbers in their names: `frame_2.png` comes before `frame_10.png`.

    `ConfigError` where there is none, one is a link to nothing, two have one name with two endings, or numbers with a
    decimal point do not tell which order is meant.
    """
    hidden = sorted(each.name for each in _named_images(folder) if each.name.startswith(HIDDEN))
    if hidden:
        what = "file(s) of macOS without a picture" if hidden[0].startswith("._") else "hidden file(s)"
        remark(f"'{folder}': {len(hidden)} {what} are passed over, such as '{hidden[0]}'")
    files = listed_images(folder)
    _check_twins(folder, files)
    if not files:
        raise ConfigError(f"source folder '{folder}' holds no image ({', '.join(IMAGE_SUFFIXES)})")
    ordered = sorted(files, key=lambda each: by_number(each.name))
    if ordered == files:
        return files
    place = next(place for place, (one, other) in enumerate(zip(files, ordered, strict=True)) if one != other)
    first, second = ordered[place].name, files[place].name
    if not is_numbered([each.stem for each in files]):
        raise ConfigError(
            f"'{folder}': '{first}' may come before or after '{second}'; fill up the numbers in their names with zeros"
        )
    remark(f"'{folder}': frames are in the order of the numbers in their names, '{first}' before '{second}'")
    return ordered


def listed_images(folder: Path) -> list[Path]:
    """Images of a folder by the text of their names."""
    found = sorted(each for each in _named_images(folder) if not each.name.startswith(HIDDEN))
    if lost := [each.name for each in found if each.is_symlink() and not each.exists()]:
        more = f", one of {len(lost)}" if len(lost) > 1 else ""
        raise ConfigError(f"'{folder}': '{lost[0]}'{more} is a link to a file that is not there: fetch the data first")
    return [each for each in found if is_file(each)]


def _named_images(folder: Path) -> Iterator[Path]:
    return (each for each in folder.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES)


def _check_twins(folder: Path, files: Sequence[Path]) -> None:
    """Refuses a picture that is there twice: with another ending, or as a link to another one of the folder."""
    seen: dict[str | Path, str] = {}
    for each in files:
        for key in (each.stem, each.resolve()):
            if (other := seen.setdefault(key, each.name)) != each.name:
                raise ConfigError(f"'{folder}': '{other}' and '{each.name}' are one picture: leave one of them")


def by_number(name: str) -> tuple[list[str | int], str]:
    """Sorts names by their text, but for numbers, which count as such."""
    parts = _NUMBERS.split(name)
    return [int(each) if number % 2 else each for number, each in enumerate(parts)], name


def is_numbered(stems: Sequence[str]) -> bool:
    """Whether every name has a number, and none a decimal point, so that the numbers tell an order."""
    return all(_NUMBERS.search(each) and not _DECIMAL.search(each) for each in stems)


def image_path(folder: Path, name: str) -> Path | None:
    """File that a table means by a name without its ending, or None; `ConfigError` where there are several."""
    candidates = [folder / name]
    if Path(name).suffix.lower() not in IMAGE_SUFFIXES:
        candidates += [folder / f"{name}{ending}" for ending in IMAGE_SUFFIXES]
    found = [path for path in candidates if name and is_file(path)]
    _check_twins(folder, found)
    return found[0] if found else None
