"""Labelled episodes read back from disk: runs of magicsim, and recordings of a real sensor with one of two tables.

A recording is a folder of images. `truth.csv` has the true states, one line a frame in the order of time, references
first:

    file,is_reference,gap_mm,force_n,flashlight
    00000.png,1,,0,0
    00030.png,0,12.5,0,0
    00041.png,0,-0.4,0.8,0

`gap_mm` is the shortest distance from the object's surface to the undeformed contact face, negative when pressed and
empty without an object; `force_n` the size of the contact force; `is_reference` and `flashlight` are 0 or 1. Files are
named relative to the folder. Instead of `force_n`, which is one number here and a vector in episodes and datasets, a
table may have that vector as `force_x_n`, `force_y_n` and `force_z_n`, or the normal force alone as `force_z_n`.

`labels.csv` has the classes: a heading and one line a frame in their order, `file`, relative to the folder, and
`class`, one of Reference, Clear, Near, Contact and Light, or nothing for a frame that is not scored.
"""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.config.presets import is_file
from magicsim.detectors.features import Episode
from magicsim.detectors.frame import Frame
from magicsim.detectors.source import read_image
from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import FrameClass
from magicsim.judge.table import TABLE, read_table
from magicsim.judge.tally import EpisodeLabels

LABELS = "labels.csv"
"""Name of the table inside the folder."""
REFERENCE = "Reference"
"""Class of the frames of the untouched sensor that make the references."""
LABEL_COLUMNS = ("file", "class")


def read_labels(folder: str | Path) -> Episode:
    """Read a labelled folder.

    Raises:
        ConfigError: No table, a column that is missing, an unknown class, or no frame of the untouched sensor.
        FrameError: An image is missing or cannot be used.
    """
    path = Path(folder) / LABELS
    references: list[Frame] = []
    frames: list[Frame] = []
    classes: list[FrameClass | None] = []
    for number, name, label in _lines(path):
        image = read_image(path.parent / name)
        if label == REFERENCE:
            references.append(image)
            continue
        if label and label not in set(FrameClass):
            raise ConfigError(f"{path.name} line {number}: {unknown_choice('class', label, [REFERENCE, *FrameClass])}")
        frames.append(image)
        classes.append(FrameClass(label) if label else None)
    if not references:
        raise ConfigError(f"'{path}' names no frame of class {REFERENCE}; the untouched sensor is needed")
    return Episode(references=references, frames=frames, classes=classes)


def _lines(path: Path) -> list[tuple[int, str, str]]:
    """Line number, file and class of every line."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = csv.DictReader(file)
            missing = [name for name in LABEL_COLUMNS if name not in (table.fieldnames or ())]
            if missing:
                msg = f"'{path}' has no column {', '.join(missing)}; its heading must be {','.join(LABEL_COLUMNS)}"
                raise ConfigError(msg)
            return [(table.line_num, row["file"] or "", (row["class"] or "").strip()) for row in table]
    except UnicodeDecodeError as error:
        raise ConfigError(f"'{path}' is not UTF-8 text: {error}") from error
    except csv.Error as error:
        raise ConfigError(f"'{path}' is not a table of comma-separated values: {error}") from error
    except OSError as error:
        raise ConfigError(f"'{path}' cannot be read: {error.strerror}") from error


TRUTH = "truth.csv"
COLUMNS = ("file", "is_reference", "gap_mm", "force_n", "flashlight")
VECTOR = ("force_x_n", "force_y_n", "force_z_n")
"""Force of the object on the sensor, a press is +z [N]."""
FORCES = (("force_n",), VECTOR, VECTOR[2:])
"""Columns that a table may have for the force: its size, the vector, or the normal force alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedEpisode:
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
    def labels(self) -> EpisodeLabels:
        """Truth of the frames after the references."""
        scored = ~self.is_reference
        return EpisodeLabels.of(self.gap_mm[scored], self.force_n[scored], self.flashlight[scored])

    def references(self) -> Iterator[Frame]:
        """Images of the untouched sensor, RGB, shape (rows, columns, 3)."""
        return self._images(self.is_reference)

    def frames(self) -> Iterator[Frame]:
        """Images after them, in order."""
        return self._images(~self.is_reference)

    def _images(self, chosen: npt.NDArray[np.bool_]) -> Iterator[Frame]:
        return (read_image(self.folder / name) for name, wanted in zip(self.files, chosen, strict=True) if wanted)


def read_recording(folder: Path) -> RecordedEpisode:
    """Reads a folder's table; images are read later, one at a time.

    Raises:
        ConfigError: No folder, no table, a wrong column, a value that is not allowed, or a missing image.
    """
    path = folder / TRUTH
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error):
        msg = f"recording '{folder}' holds no readable {TRUTH}; it needs the columns {', '.join(COLUMNS)}"
        raise ConfigError(msg) from None
    found = tuple(rows[0]) if rows else ()
    force = next((each for each in FORCES if set(found) == {*COLUMNS} - {"force_n"} | {*each}), None)
    if force is None:
        raise ConfigError(
            f"{path}: columns {', '.join(map(str, found)) or 'none'}; must be {', '.join(COLUMNS)}, or instead of "
            f"force_n {', '.join(VECTOR)} or {VECTOR[2]} alone"
        )
    values = [_row(path, number, row, force) for number, row in enumerate(rows, 2)]
    for name, *_ in values:
        if not is_file(folder / name):
            raise ConfigError(f"{path}: file '{name}' does not exist")
    reference = np.array([each[1] for each in values], bool)
    if not reference.any() or reference.all() or (np.diff(reference.astype(int)) > 0).any():
        count = f"{int(reference.sum())} of {len(values)}"
        raise ConfigError(f"{path}: {count} frames are references; must be some, and all before the rest")
    files, _, gaps, forces, lights = zip(*values, strict=True)
    return RecordedEpisode(
        folder=folder, files=files, is_reference=reference, gap_mm=np.array(gaps, np.float64),
        force_n=np.array(forces, np.float64), flashlight=np.array(lights, bool),
    )  # fmt: skip


def _row(
    path: Path, number: int, row: dict[str, str | None], force: tuple[str, ...]
) -> tuple[str, bool, float, float, bool]:
    """File, whether it is a reference, gap, force and flashlight of a line."""
    file = row["file"] or ""
    if not file:
        raise ConfigError(f"{path}, line {number}: file is empty")
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
        raise ConfigError(f"{path}, line {number}: {name} = {row[name]!r} is not allowed: must be 0 or 1")
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


def read_episode(folder: Path) -> Episode:
    """Frames and classes of one episode.

    Raises:
        ConfigError: None of these, or a table that cannot be read.
        FrameError: An image is missing or cannot be used.
    """
    if (folder / TABLE).is_file():
        return _read_run(folder)
    if (folder / TRUTH).is_file():
        recording = read_recording(folder)
        references, frames = list(recording.references()), list(recording.frames())
        return Episode(references=references, frames=frames, classes=recording.labels.classes)
    if (folder / LABELS).is_file():
        return read_labels(folder)
    kinds = f"{TABLE} (magicsim simulate), {TRUTH} or {LABELS}"
    raise ConfigError(f"'{folder}' is no labelled episode; give a folder that holds {kinds}")


def _read_run(folder: Path) -> Episode:
    rows = read_table(folder, ("file", "is_reference", "frame_class"))
    for name in {row["frame_class"] for row in rows} - {None, "", *FrameClass}:
        raise ConfigError(f"'{folder / TABLE}': {unknown_choice('frame_class', name, FrameClass)}")
    scored = [row for row in rows if not row["is_reference"]]
    return Episode(
        references=[read_image(folder / row["file"]) for row in rows if row["is_reference"]],
        frames=[read_image(folder / row["file"]) for row in scored],
        classes=[FrameClass(row["frame_class"]) if row["frame_class"] else None for row in scored],
    )
