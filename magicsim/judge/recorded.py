"""Labelled episodes read back from disk: folders that magicsim wrote, and recordings of a real sensor."""

from pathlib import Path

import numpy as np

from magicsim.detectors.scoring.episode import Episode
from magicsim.detectors.scoring.labels import LABELS, read_labels
from magicsim.detectors.sources.source import read_image
from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.judge.recording import TABLE as TRUTH
from magicsim.judge.recording import read_recording
from magicsim.judge.table import TABLE, read_table


def read_episode(folder: Path) -> Episode:
    """Frames and classes of one episode.

    Args:
        folder: What `magicsim simulate --out` wrote, or images with a table of their true states, `truth.csv`
            (`magicsim.judge.recording`), or of their classes, `labels.csv`
            (`magicsim.detectors.scoring.labels`).

    Raises:
        ConfigError: None of these, or a table that cannot be read.
        FrameError: An image is missing or cannot be used.
    """
    if (folder / TABLE).is_file():
        return _read_run(folder)
    if (folder / TRUTH).is_file():
        return _read_recording(folder)
    if (folder / LABELS).is_file():
        return read_labels(folder)
    msg = (
        f"'{folder}' is no labelled episode; give a folder that holds {TABLE} (magicsim simulate), {TRUTH} or {LABELS}"
    )
    raise ConfigError(msg)


def _read_recording(folder: Path) -> Episode:
    recording = read_recording(folder)
    states = zip(recording.gap_mm, recording.force_n, recording.flashlight, recording.is_reference, strict=True)
    classes = [
        classify_frame(gap_mm=None if np.isnan(gap) else float(gap), force_n=float(force), light_on=bool(light))
        for gap, force, light, is_reference in states
        if not is_reference
    ]
    return Episode(references=list(recording.references()), frames=list(recording.frames()), classes=classes)


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
