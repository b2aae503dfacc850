"""Labelled episodes read back from disk: runs of magicsim, and recordings of a real sensor with one of two tables.

A recording is a folder of images. `truth.csv` has the true states, one line a frame in the order of time, references
first:

    file,is_reference,gap_mm,force_n,flashlight
    00000.png,1,,0,0
    00030.png,0,12.5,0,0
    00041.png,0,-0.4,0.8,0

`gap_mm` is the shortest distance from the object's surface to the undeformed contact face, negative when pressed and
empty without an object; `force_n` the size of the contact force, empty where nobody knows: such a frame is scored only
where its gap tells that nothing touches. `is_reference` and `flashlight` are 0 or 1. Files are named relative to the
folder, each once. Instead of `force_n`, which is one number here and a vector in episodes and datasets, a
table may have that vector as `force_x_n`, `force_y_n` and `force_z_n`, or the normal force alone as `force_z_n`.

`labels.csv` has the classes: a heading and one line a frame in their order, `file`, relative to the folder, and
`class`, one of Reference, Clear, Near, Contact and Light, or nothing for a frame that is not scored.
"""

import logging
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.config.presets import is_file
from magicsim.config.tables import Line, read_table
from magicsim.detectors.features import Episode
from magicsim.detectors.frame import Frame
from magicsim.detectors.picture import once, read_image
from magicsim.detectors.source import by_number, is_numbered
from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import LIGHT_TOUCH, NEAR_MIN_MM, FrameClass, scored_class
from magicsim.judge.plausible import FELT_N, force_size, odd_labels
from magicsim.judge.tally import EpisodeLabels
from magicsim.judge.verdicts import TABLE
from magicsim.judge.verdicts import read_table as read_rows

_LOG = logging.getLogger(__name__)
LABELS = "labels.csv"
"""Name of the table inside the folder."""
REFERENCE = "Reference"
"""Class of the frames of the untouched sensor that make the references."""
LABEL_COLUMNS = ("file", "class")


def read_classes(path: Path) -> "RecordedEpisode":
    """Reads a table of classes; `ConfigError` where table, column, class or untouched frames are missing or unknown."""
    table = read_table(path)
    missing = [name for name in LABEL_COLUMNS if name not in table.heading]
    if missing:
        table.check_delimiter()
        raise ConfigError(f"'{path}' has no column {', '.join(missing)}; its heading must be {','.join(LABEL_COLUMNS)}")
    lines = [(line.where, line.text("file"), line.text("class")) for line in table.lines(LABEL_COLUMNS)]
    for where, _, label in lines:
        if label and label not in {REFERENCE, LIGHT_TOUCH, *FrameClass}:
            raise ConfigError(f"{where}: {unknown_choice('class', label, [REFERENCE, *FrameClass])}")
    labels = [label for _, _, label in lines]
    if REFERENCE not in labels:
        raise ConfigError(f"'{path}' names no frame of class {REFERENCE}; the untouched sensor is needed")
    unknown = np.full(len(lines), np.nan)
    return RecordedEpisode(
        folder=path.parent, files=tuple(file for _, file, _ in lines),
        is_reference=np.array([label == REFERENCE for label in labels]), gap_mm=unknown, force_n=unknown,
        flashlight=np.array([label == FrameClass.LIGHT for label in labels]),
        classes=tuple(scored_class(label) for label in labels if label != REFERENCE),
    )  # fmt: skip


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
    """NaN without an object, and where nobody knows."""
    force_n: npt.NDArray[np.float64]
    """Size of the contact force, or of its normal part where nothing else is known; NaN where nobody knows."""
    flashlight: npt.NDArray[np.bool_]
    classes: tuple[FrameClass | None, ...] | None = None
    """Classes of the frames after the references, where the table has these and neither gap nor force."""

    @property
    def labels(self) -> EpisodeLabels:
        """Truth of the frames after the references."""
        scored = ~self.is_reference
        known = EpisodeLabels.of(self.gap_mm[scored], self.force_n[scored], self.flashlight[scored])
        return known if self.classes is None else replace(known, classes=self.classes)

    def references(self) -> Iterator[Frame]:
        """Images of the untouched sensor, RGB, shape (rows, columns, 3)."""
        return self._images(self.is_reference)

    def frames(self) -> Iterator[Frame]:
        """Images after them, in order."""
        return self._images(~self.is_reference)

    def episode(self) -> Episode:
        """All frames in memory, with their classes."""
        return Episode(references=list(self.references()), frames=list(self.frames()), classes=self.labels.classes)

    def _images(self, chosen: npt.NDArray[np.bool_]) -> Iterator[Frame]:
        remark = once(_LOG.warning)
        wanted = (name for name, is_wanted in zip(self.files, chosen, strict=True) if is_wanted)
        return (read_image(self.folder / name, remark) for name in wanted)


def read_recording(folder: Path) -> RecordedEpisode:
    """Reads a folder's table; images are read later, one at a time.

    `ConfigError` where folder or table is missing, or a column, a value or an image is not as it must be.
    """
    path = folder / TRUTH
    if not is_file(path) and is_file(folder / LABELS):
        return read_classes(folder / LABELS)
    if not is_file(path):
        raise ConfigError(
            f"recording '{folder}' holds no readable {TRUTH}, with the columns {', '.join(COLUMNS)}, nor {LABELS}, "
            f"with {' and '.join(LABEL_COLUMNS)}"
        )
    table = read_table(path)
    force = next((each for each in FORCES if set(table.heading) == {*COLUMNS} - {"force_n"} | {*each}), None)
    if force is None:
        table.check_delimiter()
        raise ConfigError(
            f"{path}: columns {', '.join(table.heading) or 'none'}; must be {', '.join(COLUMNS)}, or instead of "
            f"force_n {', '.join(VECTOR)} or {VECTOR[2]} alone"
        )
    values = [_row(line, force) for line in table.lines(table.heading)]
    files = [each[0] for each in values]
    for name, lines in Counter(map(os.path.normpath, files)).items():
        if not is_file(folder / name):
            raise ConfigError(f"{path}: file '{name}' does not exist")
        if lines > 1:
            raise ConfigError(f"{path}: file '{name}' stands in {lines} lines; must be in one")
    reference = np.array([each[1] for each in values], bool)
    if not reference.any() or reference.all() or (np.diff(reference.astype(int)) > 0).any():
        count = f"{int(reference.sum())} of {len(values)}"
        raise ConfigError(f"{path}: {count} frames are references; must be some, and all before the rest")
    _, _, gaps, forces, lights = zip(*values, strict=True)
    names = [name for name, is_reference in zip(files, reference, strict=True) if not is_reference]
    if is_numbered([Path(name).stem for name in names]) and names != sorted(names, key=by_number):
        _LOG.warning("%s: frames are taken in the order of the lines, which their numbers do not follow", path)
    unknown = int(np.isnan(np.array(forces)[~reference & ~(np.array(gaps) > 0)]).sum())
    if unknown:
        _LOG.warning("%s: of %d frames no force tells whether something touches: they are not scored", path, unknown)
    for each in odd_labels(force_n=np.array(forces), gap_mm=np.array(gaps)):
        _LOG.warning("%s: %s", path, each)
    return RecordedEpisode(
        folder=folder, files=tuple(files), is_reference=reference, gap_mm=np.array(gaps, np.float64),
        force_n=np.array(forces, np.float64), flashlight=np.array(lights, bool),
    )  # fmt: skip


def _row(line: Line, force: tuple[str, ...]) -> tuple[str, bool, float, float, bool]:
    """File, whether it is a reference, gap, force and flashlight of a line."""
    file, is_reference, gap_mm = line.text("file"), line.certain_flag("is_reference"), line.number("gap_mm")
    if not file:
        raise ConfigError(f"{line.where}: file is empty")
    force_n = force_size([line.number(name) for name in force])
    if is_reference and (force_n > FELT_N or gap_mm <= -NEAR_MIN_MM):
        told = f"a force of {force_n:g} N" if force_n > FELT_N else f"gap_mm = {gap_mm:g}"
        raise ConfigError(f"{line.where}: a reference has {told}; must be of the untouched sensor")
    return file, is_reference, gap_mm, force_n, line.certain_flag("flashlight")


def read_episode(folder: Path) -> Episode:
    """Frames and classes of one episode, with the errors of `read_recording`; `FrameError` of an image."""
    if (folder / TABLE).is_file():
        return _read_run(folder)
    if (folder / TRUTH).is_file() or (folder / LABELS).is_file():
        return read_recording(folder).episode()
    kinds = f"{TABLE} (magicsim simulate), {TRUTH} or {LABELS}"
    raise ConfigError(f"'{folder}' is no labelled episode; give a folder that holds {kinds}")


def _read_run(folder: Path) -> Episode:
    rows = read_rows(folder, ("file", "is_reference", "frame_class"))
    for name in {row["frame_class"] for row in rows} - {None, "", LIGHT_TOUCH, *FrameClass}:
        raise ConfigError(f"'{folder / TABLE}': {unknown_choice('frame_class', name, FrameClass)}")
    scored = [row for row in rows if not row["is_reference"]]
    return Episode(
        references=[read_image(folder / row["file"]) for row in rows if row["is_reference"]],
        frames=[read_image(folder / row["file"]) for row in scored],
        classes=[scored_class(row["frame_class"]) for row in scored],
    )
