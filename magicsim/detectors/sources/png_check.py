"""Whether a PNG file is whole, so that a damaged one is refused before a decoder prints about it."""

import zlib

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
