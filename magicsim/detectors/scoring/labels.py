"""Labelled episodes of recorded frames: a folder of images with a table that says what each one shows.

`labels.csv` has a heading and one line a frame in their order: `file`, relative to the folder, and `class`, one of
Reference, Clear, Near, Contact and Light, or nothing for a frame that is not scored.
"""

import csv
from pathlib import Path

from magicsim.detectors.frame import Frame
from magicsim.detectors.scoring.episode import Episode
from magicsim.detectors.sources.source import read_image
from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import FrameClass

LABELS = "labels.csv"
"""Name of the table inside the folder."""

REFERENCE = "Reference"
"""Class of the frames of the untouched sensor that make the references."""

_COLUMNS = ("file", "class")


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
            msg = f"{path.name} line {number}: {unknown_choice('class', label, [REFERENCE, *FrameClass])}"
            raise ConfigError(msg)
        frames.append(image)
        classes.append(FrameClass(label) if label else None)
    if not references:
        msg = f"'{path}' names no frame of class {REFERENCE}; the untouched sensor is needed"
        raise ConfigError(msg)
    return Episode(references=references, frames=frames, classes=classes)


def _lines(path: Path) -> list[tuple[int, str, str]]:
    """Line number, file and class of every line."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = csv.DictReader(file)
            missing = [name for name in _COLUMNS if name not in (table.fieldnames or ())]
            if missing:
                msg = f"'{path}' has no column {', '.join(missing)}; its heading must be {','.join(_COLUMNS)}"
                raise ConfigError(msg)
            return [(table.line_num, row["file"] or "", (row["class"] or "").strip()) for row in table]
    except UnicodeDecodeError as error:
        msg = f"'{path}' is not UTF-8 text: {error}"
        raise ConfigError(msg) from error
    except csv.Error as error:
        msg = f"'{path}' is not a table of comma-separated values: {error}"
        raise ConfigError(msg) from error
    except OSError as error:
        msg = f"'{path}' cannot be read: {error.strerror}"
        raise ConfigError(msg) from error
