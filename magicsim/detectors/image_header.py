"""The size of an image by the first bytes of its file, and whether a PNG file is whole, before either is decoded.

BMP, JPEG (ITU T.81, annex B), PNG (section 11.2.2), PPM, TIFF 6.0 (section 2) and WebP (RFC 9649).
"""

import re
import zlib
from collections.abc import Callable

from magicsim.errors import FrameError

MAX_PIXELS = 50_000_000
"""Largest image: more than any sensor's camera has, and 150 MB decoded."""
HEAD_BYTES = 1 << 20
"""First bytes of a file in which its size is looked for; metadata of a JPEG file may come before it."""
Size = tuple[int, int]
"""Columns and rows."""


def image_size(head: bytes) -> Size | None:
    """Columns and rows that the file of an image announces; None where it is none of the known kinds, or breaks off.

    Args:
        head: The first bytes of the file, up to `HEAD_BYTES`.
    """
    for signature, read in _READERS:
        if re.match(signature, head, re.DOTALL):
            return read(head)
    return None


def check_pixels(what: str, columns: int, rows: int) -> None:
    """Refuses a picture that is too large.

    Args:
        what: What it is, with its name.
        columns: Its width [px].
        rows: Its height [px].

    Raises:
        FrameError: It has more than `MAX_PIXELS`.
    """
    if columns * rows > MAX_PIXELS:
        msg = f"{what} has {columns} x {rows} pixels; at most {MAX_PIXELS / 1e6:.0f} million are allowed"
        raise FrameError(msg)


def _whole(head: bytes, size: Size, end: int) -> Size | None:
    return size if len(head) >= end else None


def _png(head: bytes) -> Size | None:
    is_whole = len(head) >= 33 and zlib.crc32(head[12:29]) == int.from_bytes(head[29:33])  # noqa: PLR2004
    return (int.from_bytes(head[16:20]), int.from_bytes(head[20:24])) if is_whole else None


def _bmp(head: bytes) -> Size | None:
    width, height = (int.from_bytes(head[begin : begin + 4], "little", signed=True) for begin in (18, 22))
    return _whole(head, (abs(width), abs(height)), 26)


def _jpeg(head: bytes) -> Size | None:
    """Walks the segments (marker, length, content) to the frame header, markers C0 to CF without C4, C8 and CC."""
    at = 2
    while at + 9 <= len(head) and head[at] == 0xFF:  # noqa: PLR2004 - how a marker begins
        marker = head[at + 1]
        if marker == 0xFF:  # noqa: PLR2004 - filling
            at += 1
        elif 0xC0 <= marker <= 0xCF and marker not in {0xC4, 0xC8, 0xCC}:  # noqa: PLR2004
            return int.from_bytes(head[at + 7 : at + 9]), int.from_bytes(head[at + 5 : at + 7])
        else:
            at += 2 + int.from_bytes(head[at + 2 : at + 4])
    return None


def _ppm(head: bytes) -> Size | None:
    found = re.match(rb"P[1-7](?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,9})\s", head[:4096])
    pam = re.search(rb"WIDTH\s+(\d{1,9})\s+HEIGHT\s+(\d{1,9})", head[:4096]) if head[:2] == b"P7" else None
    found = pam or found
    return (int(found[1]), int(found[2])) if found else None


def _tiff(head: bytes) -> Size | None:
    """Reads tags 256 and 257, width and height, of the first directory."""
    order: str = "little" if head[:1] == b"I" else "big"

    def number(at: int, count: int) -> int:
        return int.from_bytes(head[at : at + count], order)  # type: ignore[arg-type]

    directory = number(4, 4)
    values = {}
    for entry in range(directory + 2, min(directory + 2 + 12 * number(directory, 2), len(head) - 11), 12):
        values[number(entry, 2)] = number(entry + 8, 2 if number(entry + 2, 2) == 3 else 4)  # noqa: PLR2004 - a short
    return (values[256], values[257]) if {256, 257} <= set(values) else None


def _webp(head: bytes) -> Size | None:
    kind = head[12:16]
    if kind == b"VP8X":
        return _whole(head, (1 + int.from_bytes(head[24:27], "little"), 1 + int.from_bytes(head[27:30], "little")), 30)
    if kind == b"VP8L":
        bits = int.from_bytes(head[21:25], "little")
        return _whole(head, (1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)), 25)
    width, height = (int.from_bytes(head[begin : begin + 2], "little") & 0x3FFF for begin in (26, 28))
    return _whole(head, (width, height), 30)


_READERS: tuple[tuple[bytes, Callable[[bytes], Size | None]], ...] = (
    (rb"\x89PNG\r\n\x1a\n", _png),
    (rb"BM", _bmp),
    (rb"\xff\xd8", _jpeg),
    (rb"P[1-7]\s", _ppm),
    (rb"II\x2a\0|MM\0\x2a", _tiff),
    (rb"RIFF....WEBP", _webp),
)


SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""First bytes of every PNG file."""

_LENGTH, _NAME, _SUM = 4, 4, 4


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
