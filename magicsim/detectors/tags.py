"""What picture files say beside their pixels: how they are turned, what their colours mean, and which are copies."""

import re
import struct
import zlib
from collections.abc import Iterator

SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""First bytes of every PNG file."""
NETPBM = re.compile(rb"\s*P6" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,6})" + rb"\s")
"""Header of a PPM: columns, rows, largest value."""
SEARCHED_BYTES = 1 << 16
"""Head of a file that holds what stands before its pixels."""
UPRIGHT, MOST_ORIENTATION, ORIENTATION, SUBFILE = 1, 8, 0x0112, 0x00FE
"""Orientation of a picture that is not turned, the largest, the tag that tells it, and that of reduced copies: Exif
2.32, 4.6.4, and TIFF 6.0, section 8."""
PHOTOMETRIC, EXTRA_SAMPLES = 262, 338
"""Tags of what the numbers of a TIFF mean, and of opacity beside them."""
ABSTRACT = {5: "CMYK", 8: "CIE Lab", 9: "CIE Lab", 10: "CIE Lab"}
"""Photometric interpretations without red, green and blue."""
GREY_WITH_OPACITY, COLOUR_WITH_OPACITY = 4, 6
"""Colour types of PNG: PNG 3, table 8."""
SCREEN_GAMMA = range(45_000, 46_001)
"""Values of a PNG's `gAMA` that are those of sRGB, 1 / 2.2."""
MOST_VALUE = 255
_WHOLE = {3: "H", 4: "I"}
"""Types of whole numbers of a TIFF."""
_FRAME_OF_FOUR = re.compile(rb"\xff[\xc0-\xc3\xc5-\xc7\xc9-\xcb\xcd-\xcf]\x00\x14\x08.{4}\x04", re.DOTALL)
"""Head of a JPEG's frame of four components, of 8 bit: ITU-T T.81, B.2.2."""
_SRGB = (b"sRGB", b"s\x00R\x00G\x00B")
"""How profiles of it call themselves."""


def colour_problem(content: bytes) -> str | None:
    """Why the numbers of a picture are no red, green and blue of 0 to 255; None where they are, or nobody says."""
    if content.startswith(SIGNATURE):
        return "is grey; must be colour with 3 (RGB)" if content[25:26] == bytes([GREY_WITH_OPACITY]) else None
    if content.startswith(b"\xff\xd8"):
        return "is CMYK; must be RGB" if _FRAME_OF_FOUR.search(content[:SEARCHED_BYTES]) else None
    if head := NETPBM.match(content):
        most = int(head[3])
        return None if most >= MOST_VALUE else f"has values up to {most}; must be up to {MOST_VALUE}"
    kind = ABSTRACT.get(next(directories(content), {}).get(PHOTOMETRIC, 0))
    return f"is {kind}; must be RGB" if kind else None


def has_opacity(content: bytes) -> bool:
    """Whether a picture says how much of what is behind it shines through."""
    if content.startswith(SIGNATURE):
        return content[25:26] == bytes([COLOUR_WITH_OPACITY]) or b"tRNS" in content[: _pixels_at(content)]
    if content[:4] == b"RIFF":
        return content[12:16] in {b"VP8X", b"VP8L"}
    return EXTRA_SAMPLES in next(directories(content), {})


def colour_remark(content: bytes) -> str | None:
    """What a picture says of its colours that is not applied; None where they are those of sRGB."""
    profile = b""
    if content.startswith(SIGNATURE):
        head = content[: _pixels_at(content)]
        at = head.find(b"gAMA")
        if at > 0 and b"sRGB" not in head and int.from_bytes(head[at + 4 : at + 8]) not in SCREEN_GAMMA:
            return f"have gamma {int.from_bytes(head[at + 4 : at + 8]) / 1e5:g}, {NOT_APPLIED}"
        at = head.find(b"iCCP")
        if at > 0:
            start = head.find(b"\x00", at + 4) + 2
            try:
                profile = zlib.decompressobj().decompress(head[start:], SEARCHED_BYTES)
            except zlib.error:
                return None
    elif content.startswith(b"\xff\xd8"):
        at = content.find(b"ICC_PROFILE\x00", 0, SEARCHED_BYTES)
        profile = content[at : at + SEARCHED_BYTES // 8] if at > 0 else b""
    is_other = bool(profile) and not any(name in profile for name in _SRGB)
    return f"have a colour profile other than sRGB, {NOT_APPLIED}" if is_other else None


NOT_APPLIED = "which is not applied: references and frames need to have it both"


def _pixels_at(png: bytes) -> int:
    return max(png.find(b"IDAT"), 0)


def exif_orientation(content: bytes) -> int:
    """Orientation 1..8 that a file's metadata tell, 1 (upright) where they tell none: JPEG, PNG, WebP and TIFF."""
    starts = [0] if content[:2] in {b"II", b"MM"} else []
    for mark, skipped in ((b"Exif\x00\x00", 6), (b"eXIf", 4), (b"EXIF", 8)):
        at = content.find(mark)
        starts += [at + skipped] if at >= 0 else []
    for start in starts:
        found = next(directories(content[start:]), {}).get(ORIENTATION, UPRIGHT)
        if UPRIGHT < found <= MOST_ORIENTATION:
            return found
    return UPRIGHT


_LAYOUTS = {42: ("I", "H"), 43: ("Q", "Q")}
"""Types of offsets and of counts by the number after the order of bytes: TIFF 6.0, section 2, and BigTIFF."""


def directories(tiff: bytes) -> Iterator[dict[int, int]]:
    """Values of the tags of each directory whose value is a whole number that stands beside its tag."""
    order = {b"II": "<", b"MM": ">"}.get(tiff[:2])
    seen: set[int] = set()
    try:
        layout = _LAYOUTS.get(struct.unpack_from(f"{order}H", tiff, 2)[0]) if order else None
        if layout is None:
            return
        offset, number, head = f"{order}{layout[0]}", f"{order}{layout[1]}", f"{order}HH{layout[0]}"
        [at] = struct.unpack_from(offset, tiff, struct.calcsize(offset))
        while at and at not in seen:
            seen.add(at)
            [count] = struct.unpack_from(number, tiff, at)
            at += struct.calcsize(number)
            values = {}
            for _ in range(count):
                tag, kind, _ = struct.unpack_from(head, tiff, at)
                if kind in _WHOLE:
                    [values[tag]] = struct.unpack_from(f"{order}{_WHOLE[kind]}", tiff, at + struct.calcsize(head))
                at += struct.calcsize(head) + struct.calcsize(offset)
            [at] = struct.unpack_from(offset, tiff, at)
            yield values
    except struct.error:  # it breaks off, which its decoder tells
        return
