"""Recorded episodes of a real sensor: a folder of images and a table of labels, `truth.csv`.

One line a frame, in the order of time, references first:

    file,is_reference,gap_mm,force_n,flashlight
    00000.png,1,,0,0
    00030.png,0,12.5,0,0
    00041.png,0,-0.4,0.8,0

`gap_mm` is the shortest distance from the object's surface to the undeformed contact face, negative when pressed and
empty without an object; `force_n` the size of the contact force; `is_reference` and `flashlight` are 0 or 1. Files are
named relative to the folder. Instead of `force_n`, which is one number here and a vector in episodes and datasets, a
table may have that vector as `force_x_n`, `force_y_n` and `force_z_n`, or the normal force alone as `force_z_n`.
"""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.config.presets import is_file
from magicsim.detectors.frame import Frame
from magicsim.detectors.sources.source import read_image
from magicsim.errors import ConfigError

TABLE = "truth.csv"
COLUMNS = ("file", "is_reference", "gap_mm", "force_n", "flashlight")
VECTOR = ("force_x_n", "force_y_n", "force_z_n")
"""Force of the object on the sensor, a press is +z [N]."""
FORCES = (("force_n",), VECTOR, VECTOR[2:])
"""Columns that a table may have for the force: its size, the vector, or the normal force alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Labels of a recorded episode and where its images are; arrays have one entry a frame, references first."""

    folder: Path
    files: tuple[str, ...]
    is_reference: npt.NDArray[np.bool_]
    gap_mm: npt.NDArray[np.float64]
    """NaN without an object."""
    force_n: npt.NDArray[np.float64]
    """Size of the contact force, or of its normal part where nothing else is known."""
    flashlight: npt.NDArray[np.bool_]

    @property
    def scored(self) -> npt.NDArray[np.bool_]:
        """Frames after the references."""
        return ~self.is_reference

    def references(self) -> Iterator[Frame]:
        """Images of the untouched sensor, RGB, shape (rows, columns, 3)."""
        return (read_image(self.folder / name) for name in self._named(self.is_reference))

    def frames(self) -> Iterator[Frame]:
        """Images after them, in order."""
        return (read_image(self.folder / name) for name in self._named(self.scored))

    def _named(self, chosen: npt.NDArray[np.bool_]) -> list[str]:
        return [name for name, wanted in zip(self.files, chosen, strict=True) if wanted]


def read_recording(folder: Path) -> Recording:
    """Reads a folder's table; images are read later, one at a time.

    Raises:
        ConfigError: No folder, no table, a wrong column, a value that is not allowed, or a missing image.
    """
    path = folder / TABLE
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error):
        msg = f"recording '{folder}' holds no readable {TABLE}; it needs the columns {', '.join(COLUMNS)}"
        raise ConfigError(msg) from None
    found = tuple(rows[0]) if rows else ()
    force = next((each for each in FORCES if set(found) == {*COLUMNS} - {"force_n"} | {*each}), None)
    if force is None:
        msg = (
            f"{path}: columns {', '.join(map(str, found)) or 'none'}; must be {', '.join(COLUMNS)}, or instead of "
            f"force_n {', '.join(VECTOR)} or {VECTOR[2]} alone"
        )
        raise ConfigError(msg)
    values = [_row(path, number, row, force) for number, row in enumerate(rows, 2)]
    for name, *_ in values:
        if not is_file(folder / name):
            msg = f"{path}: file '{name}' does not exist"
            raise ConfigError(msg)
    reference = np.array([each[1] for each in values], bool)
    if not reference.any() or reference.all() or (np.diff(reference.astype(int)) > 0).any():
        count = f"{int(reference.sum())} of {len(values)}"
        msg = f"{path}: {count} frames are references; must be some, and all before the rest"
        raise ConfigError(msg)
    return Recording(
        folder=folder,
        files=tuple(each[0] for each in values),
        is_reference=reference,
        gap_mm=np.array([each[2] for each in values], np.float64),
        force_n=np.array([each[3] for each in values], np.float64),
        flashlight=np.array([each[4] for each in values], bool),
    )


def _row(
    path: Path, number: int, row: dict[str, str | None], force: tuple[str, ...]
) -> tuple[str, bool, float, float, bool]:
    file = row["file"] or ""
    if not file:
        msg = f"{path}, line {number}: file is empty"
        raise ConfigError(msg)
    parts = [_number(path, number, row, name, empty=0.0) for name in force]
    return (
        file,
        _flag(path, number, row, "is_reference"),
        _number(path, number, row, "gap_mm", empty=math.nan),
        parts[0] if force == ("force_n",) else math.hypot(*parts),
        _flag(path, number, row, "flashlight"),
    )


def _flag(path: Path, number: int, row: dict[str, str | None], name: str) -> bool:
    if row[name] not in {"0", "1"}:
        msg = f"{path}, line {number}: {name} = {row[name]!r} is not allowed: must be 0 or 1"
        raise ConfigError(msg)
    return row[name] == "1"


def _number(path: Path, number: int, row: dict[str, str | None], name: str, *, empty: float) -> float:
    text = (row[name] or "").strip()
    if not text:
        return empty
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        msg = f"{path}, line {number}: {name} = {row[name]!r} is not allowed: must be a finite number or empty"
        raise ConfigError(msg)
    return value
