"""Pictures in files: their pixels as RGB, upright as the file says, one or several of them."""

import zlib
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.conventions import MAX_PIXELS
from magicsim.detectors.frame import Frame, check_frame, check_pixels
from magicsim.detectors.tags import (
    NETPBM,
    SEARCHED_BYTES,
    SIGNATURE,
    SUBFILE,
    UPRIGHT,
    colour_problem,
    colour_remark,
    directories,
    exif_orientation,
    has_opacity,
)
from magicsim.detectors.video import Remark, quiet_opencv
from magicsim.errors import FrameError
from magicsim.waiting import unheard

IMAGE_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".ppm", ".tif", ".tiff", ".webp")
"""File name endings that are read as images, in any case."""
MAX_BYTES = 8 * MAX_PIXELS
"""Largest image file: so many pixels of four channels of 16 bit."""
AnyPixels = npt.NDArray[Any]
"""Pixels of any type as OpenCV has them: shape (rows, columns), or with channels behind."""
_FLAGS = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH
"""Turns a picture as its Exif orientation says, keeps its depth, and drops opacity."""
HEAD_BYTES = 4096
"""Head of a file that is looked at before the whole is read."""
WEBP_ANIMATION = 2
"""Flag of an animated WebP in its extended header."""


def once(remark: Remark) -> Remark:
    """A remark that passes every line on only once."""
    said: set[str] = set()

    def first(line: str) -> None:
        if line not in said:
            said.add(line)
            remark(line)

    return first


def read_image(path: str | Path, remark: Remark = unheard) -> Frame:
    """Read an image file as RGB, shape (rows, columns, 3), turned as its metadata says.

    Args:
        path: File with one picture.
        remark: Hears that it was turned, or that its format loses detail.

    Raises:
        FrameError: The file is missing, cannot be decoded, holds several pictures, or not 8-bit colour.
    """
    path = Path(path)
    content = _content(path)
    pages = _pages(content)
    if len(pages) > 1:
        raise FrameError(f"image '{path}' holds {len(pages)} pictures; must hold one here")
    return _frame(path, content, _pixels(path, content), remark)


def read_pictures(path: Path, remark: Remark = unheard) -> list[Callable[[], Frame]]:
    """What makes each picture of an image file, as `read_image` makes one, in order."""
    if not _may_hold_several(path):
        return [partial(read_image, path, remark)]
    content = _content(path)
    pages = _pages(content)
    if len(pages) == 1:
        return [partial(read_image, path, remark)]
    if content.startswith(b"P6"):
        raise FrameError(f"image '{path}' holds {len(pages)} pictures, of which one is read: save them one by one")

    @cache
    def animation() -> Sequence[AnyPixels]:
        return _quietly(path, lambda data: cv2.imdecodemulti(data, _FLAGS)[1], content) or ()

    def picture(page: int) -> Frame:
        """One page of a TIFF, or one frame of an animated PNG or WebP, which rest on each other."""
        if content[:2] in {b"II", b"MM"}:
            decode = partial(cv2.imdecodemulti, flags=_FLAGS, range=(page, page + 1))
            found = _quietly(path, lambda data: decode(data)[1], content) or ()
        else:
            found = animation()[page : page + 1]
        return _frame(path, content, next(iter(found), None), remark)

    return [partial(picture, page) for page in pages]


def _may_hold_several(path: Path) -> bool:
    """Whether a look at the head of a file does not exclude that it holds several pictures."""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except (OSError, ValueError):
        return False  # told when its turn comes
    if head.startswith(SIGNATURE):
        return b"acTL" in head or b"IDAT" not in head
    return head[:2] in {b"II", b"MM", b"P6"} or head[:4] == b"RIFF"


def _content(path: Path) -> bytes:
    try:
        length = path.stat().st_size
        if length <= MAX_BYTES:
            return path.read_bytes()
    except (OSError, ValueError) as error:
        raise FrameError(f"image '{path}' cannot be read: {getattr(error, 'strerror', None) or error}") from error
    raise FrameError(f"image '{path}' has {length / 1e6:.0f} MB; at most {MAX_BYTES / 1e6:.0f} MB are allowed")


def _pixels(path: Path, content: bytes) -> AnyPixels | None:
    """The one picture of a file, its first page where there are smaller copies of it."""
    if not content or is_damaged_png(content):
        return None
    pixels: AnyPixels | None = _quietly(path, lambda data: cv2.imdecode(data, _FLAGS), content)
    return pixels


def _frame(path: Path, content: bytes, pixels: AnyPixels | None, remark: Remark) -> Frame:
    """Pixels as OpenCV gives them, checked, as RGB; None is a picture that is not whole."""
    if pixels is None:
        allowed = f"must be a whole image file ({', '.join(IMAGE_SUFFIXES)})"
        raise FrameError(f"image '{path}' cannot be decoded; {allowed}")
    check_pixels(f"image '{path}'", pixels.shape[1], pixels.shape[0])
    if problem := colour_problem(content):
        raise FrameError(f"image '{path}' {problem}")
    if has_opacity(content) and _is_transparent(path, content):
        if content[:2] in {b"II", b"MM"}:  # its decoder has changed the colours by it
            raise FrameError(f"image '{path}' is partly transparent: save it without opacity")
        remark(f"images in '{path.parent}' are partly transparent: their colours are taken as they are behind that")
    channels = pixels.shape[2] if pixels.ndim > len(("rows", "columns")) else 1
    if channels not in {3, 4}:  # opacity is dropped
        raise FrameError(f"image '{path}' has {channels} channel(s); must be colour with 3 (RGB)")
    try:
        frame = check_frame(pixels[:, :, 2::-1])  # RGB from OpenCV's BGR or BGRA
    except FrameError as error:
        raise FrameError(f"image '{path}': {error}") from error
    _remark_on(path, content, remark)
    return frame


def _is_transparent(path: Path, content: bytes) -> bool:
    """Whether any pixel of the first picture lets through what is behind it."""
    whole: AnyPixels | None = _quietly(path, lambda data: cv2.imdecode(data, cv2.IMREAD_UNCHANGED), content)
    if whole is None or whole.ndim < len(("rows", "columns", "channels")) or whole.shape[2] not in {2, 4}:
        return False
    return bool((whole[..., -1] < np.iinfo(whole.dtype).max).any())


def _quietly(path: Path, decode: Callable[[AnyPixels], Any], content: bytes) -> Any:  # noqa: ANN401 - of OpenCV
    """What OpenCV makes of a file; None where it refuses it."""
    try:
        with quiet_opencv():
            return decode(np.frombuffer(content, np.uint8))
    except cv2.error as error:
        if "MAX_IMAGE" in str(error):  # the limit that OpenCV is loaded with, see `magicsim.__init__`
            limit = f"at most {MAX_PIXELS / 1e6:.0f} million are allowed"
            raise FrameError(f"image '{path}' has too many pixels; {limit}") from None
        return None


def _remark_on(path: Path, content: bytes, remark: Remark) -> None:
    lossy = "JPEG" if content.startswith(b"\xff\xd8") else ""
    if content[:4] == b"RIFF" and b"VP8 " in content[:HEAD_BYTES]:
        lossy = "WebP that is not lossless"
    if lossy:
        remark(
            f"images in '{path.parent}' are {lossy}, which loses detail: frames of something near may be judged "
            "Touched; save PNG"
        )
    if content.startswith(b"\xff\xd8") and b"MPF\x00" in content[:SEARCHED_BYTES]:
        remark(f"images in '{path.parent}' hold further pictures (CIPA DC-007), which are passed over")
    if said := colour_remark(content):
        remark(f"images in '{path.parent}' {said}")
    orientation = exif_orientation(content)
    if orientation != UPRIGHT:
        remark(
            f"images in '{path.parent}' are turned as their Exif orientation {orientation} says; references and "
            "frames have to be turned alike"
        )


def _pages(content: bytes) -> list[int]:
    """Numbers of the pictures in a file but for reduced copies: pages of a TIFF, frames of an animated PNG or WebP."""
    if content.startswith(SIGNATURE):
        at = content.find(b"acTL", 0, max(content.find(b"IDAT"), 0))  # animation control: PNG 3, section 11.3.6.1
        return list(range(max(1, int.from_bytes(content[at + 4 : at + 8])) if at >= 0 else 1))
    if content.startswith(b"P6"):
        return list(range(_count_netpbm(content)))
    if content[:4] == b"RIFF" and content[12:16] == b"VP8X" and content[20] & WEBP_ANIMATION:
        return list(range(max(1, content.count(b"ANMF"))))
    return [page for page, values in enumerate(directories(content)) if not values.get(SUBFILE, 0) & 1] or [0]


def _count_netpbm(content: bytes) -> int:
    """How many pictures stand one after the other in a PPM (netpbm, `ppm`): headers, each with its pixels behind."""
    count, at = 0, 0
    while (head := NETPBM.match(content, at)) is not None:
        columns, rows, most = (int(each) for each in head.groups())
        count, at = count + 1, head.end() + 3 * columns * rows * (2 if most > 255 else 1)  # noqa: PLR2004
    return max(1, count)


def is_damaged_png(content: bytes) -> bool:
    """Whether the bytes start as a PNG and then break off or fail a chunk's checksum.

    Walks the chunks (length, name, data, CRC-32 of name and data) up to `IEND`: PNG specification, section 5.
    """
    if not content.startswith(SIGNATURE):
        return False
    at = len(SIGNATURE)
    while at + 12 <= len(content):  # length, name and checksum have four bytes each
        end = at + 8 + int.from_bytes(content[at : at + 4])
        body = content[at + 4 : end]
        if zlib.crc32(body) != int.from_bytes(content[end : end + 4]):
            return True
        if body.startswith(b"IEND"):
            return False
        at = end + 4
    return True
