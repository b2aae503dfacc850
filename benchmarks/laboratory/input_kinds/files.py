"""Files of recordings that are not what they look like: other colours, pictures twice or not there, other units."""

import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from laboratory.input_kinds.recordings import (
    FORCES_N,
    PRESS,
    REST,
    forces,
    images,
    kind,
    read,
    refuses,
    same,
    says,
    told,
)
from laboratory.input_kinds.registry import Attempt

SEEN = Image.fromarray(PRESS[10])


def _picture(name: str, write: Callable[[Path], object], *words: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        write(folder / name)
        return refuses(lambda: read(folder / name), *words)

    return attempt


def _with_gamma(folder: Path) -> str | None:
    path, body = folder / "a.png", b"gAMA" + struct.pack(">I", 100_000)
    SEEN.save(path)
    content = path.read_bytes()
    chunk = struct.pack(">I", 4) + body + struct.pack(">I", zlib.crc32(body))
    path.write_bytes(content[:33] + chunk + content[33:])
    return says(read(path)[1], "have gamma 1, which is not applied")


def _half(path: Path) -> None:
    Image.fromarray(np.dstack([PRESS[10], np.full(PRESS[10].shape[:2], 128, np.uint8)])).save(path)


def _half_png(folder: Path) -> str | None:
    _half(folder / "a.png")
    found, lines = read(folder / "a.png")
    return same(found, [PRESS[10]]) or says(lines, "are partly transparent")


def _dim(path: Path) -> None:
    path.write_bytes(b"P6\n80 60\n127\n" + (PRESS[10] // 2).tobytes())


kind(
    "colours of a file",
    CMYK=("refused", _picture("a.jpg", lambda path: SEEN.convert("CMYK").save(path), "is CMYK; must be RGB")),
    half_transparent_TIFF=("refused", _picture("a.tif", _half, "is partly transparent")),
    half_transparent_PNG=("its colours, and a line", _half_png),
    values_up_to_127=("refused", _picture("a.ppm", _dim, "has values up to 127; must be up to 255")),
    grey_with_opacity=("refused", _picture("a.png", lambda path: SEEN.convert("LA").save(path), "is grey")),
    linear_gamma=("told", _with_gamma),
)


def _among_references(change: Callable[[Path], object], *words: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        path = images(folder, forces())
        change(folder / "rest")
        return refuses(lambda: told(path), *words)

    return attempt


def _hidden(folder: Path) -> str | None:
    path = images(folder, forces())
    cv2.imwrite(str(folder / "rest" / ".half_copied.png"), PRESS[10])
    return says(told(path), r"1 hidden file\(s\) are passed over, such as '.half_copied.png'")


kind(
    "pictures twice or not there",
    two_endings=(
        "refused: both",
        _among_references(
            lambda rest: cv2.imwrite(str(rest / "0003.bmp"), REST[3]), "'0003.bmp' and '0003.png' are one"
        ),
    ),
    link_to_the_newest=(
        "refused: both",
        _among_references(
            lambda rest: os.symlink(rest / "0003.png", rest / "latest.png"), "'0003.png' and 'latest.png' are one"
        ),
    ),
    link_to_nothing=(
        "refused by name",
        _among_references(lambda rest: os.symlink("/nowhere/9.png", rest / "0009.png"), "'0009.png' is a link to a"),
    ),
    hidden=("passed over with a word", _hidden),
)


def _timed(time: Callable[[int], str], heading: str, *words: str) -> Attempt:
    def attempt(folder: Path) -> str | None:
        lines = [f"{number:04d}.png,{force},{time(number)}" for number, force in enumerate(FORCES_N)]
        text = "\n".join([f"image_name,f,{heading}", *lines, ""])
        return says(told(images(folder, text=text, columns=f'force_n = "f", time_s = "{heading}"')), *words)

    return attempt


def _milli(folder: Path) -> str | None:
    lines = [f"{number:04d}.png,{force * 100}" for number, force in enumerate(FORCES_N)]
    path = images(folder, text="\n".join(["image_name,F (mN)", *lines, ""]), columns='force_n = "F (mN)"')
    return says(told(path), r"column 'F \(mN\)' is in mN by its name: set scale.force_n = 0.001")


kind(
    "units and digits of a table",
    heading_in_mN=("told with the factor", _milli),
    heading_in_ns=("told with the factor", _timed(lambda number: str(number * 10**8), "t_ns", "scale.time_s = 1e-09")),
    microseconds=("told with the factor", _timed(lambda number: str(number * 10**5), "t", "microseconds.* = 1e-06")),
    six_digits_of_Unix_time=(
        "told",
        _timed(lambda number: f"{1764181390 + number / 10:g}", "t", "have the time of the row before"),
    ),
)
