"""An episode as a Parquet table: one row a frame with its truth and every profile's verdict."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.detectors.verdict import NUMBERS, WORDS
from magicsim.errors import ConfigError
from magicsim.judge.verdicts import Judgement
from magicsim.scenes.scene import TaxelSettings
from magicsim.simulation.episode import Episode, SimulatedFrame, frame_file, truth_row
from magicsim.simulation.touch_truth import TOUCH_COLUMNS, touch_columns

TABLE = "episode.parquet"
"""Name of the table in a folder of results."""
MARKERS = ("markers_mm", "markers_px")
READ = {
    field.name: field for field in (
        pa.field("file", pa.string(), nullable=False), pa.field("is_reference", pa.bool_(), nullable=False),
        pa.field("frame_class", pa.string()), pa.field("gap_mm", pa.float64()),
        pa.field("force_n", pa.list_(pa.float64(), 3), nullable=False),
        pa.field("flashlight", pa.bool_(), nullable=False),
    )
}  # fmt: skip
"""Columns that are read back, and whether they may have nulls."""


def write_table(path: Path, episode: Episode, judgements: Sequence[Judgement]) -> None:
    """Writes truth and verdicts, one row a frame, references included.

    Columns that a dataset has too are named as there. Only labels that were not asked for are null: elsewhere a text is
    empty and a number NaN where there is nothing.
    """
    skipped = len(episode.references)
    marked, taxels = episode.scene.design.markers is not None, episode.scene.output.taxels
    rows = [
        _row(frame) | (_marker_row(frame) if marked else {}) | (_touch_row(frame, taxels) if taxels else {})
        for frame in episode.frames
    ]
    for judgement in judgements:
        for row, frame in zip(rows, episode.frames, strict=True):
            number = frame.truth.index - skipped
            verdict = judgement.verdicts[number].as_dict() if number >= 0 else {}
            for key in (*NUMBERS, *WORDS):
                row[f"{judgement.profile}_{key}"] = verdict.get(key, math.nan if key in NUMBERS else "")
            row[f"{judgement.profile}_weak"] = bool(verdict.get("weak"))
    schema = _schema(judgements, marked=marked, touch=rows[0] if taxels else {})
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), path, compression="zstd")


def read_table(folder: Path, names: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of the table in a folder of results.

    Raises:
        ConfigError: The table cannot be read, lacks a column, or holds something else there; the message names it.
    """
    path, schema = folder / TABLE, pa.schema([READ[name] for name in names])
    try:
        found = pq.read_table(path, columns=list(names)).select(list(names)).cast(schema)
    except (OSError, pa.ArrowException, KeyError, ValueError) as error:
        reason = str(error.args[-1] if error.args else error).partition("\n")[0]
        raise ConfigError(f"'{path}' cannot be read: {reason}") from None
    rows: list[dict[str, Any]] = found.to_pylist()
    return rows


def _schema(judgements: Sequence[Judgement], *, marked: bool, touch: dict[str, Any]) -> pa.Schema:
    number, vector = pa.float64(), pa.list_(pa.float64(), 3)
    picture = pa.struct({"bytes": pa.binary(), "path": pa.string()})
    fields = [
        ("step", pa.int32()), ("file", pa.string()), ("time_s", number), ("is_reference", pa.bool_()),
        ("frame_class", pa.string()), ("gap_mm", number), ("x_mm", number), ("y_mm", number), ("twist_deg", number),
        ("flashlight", pa.bool_()), ("contact", pa.bool_()), ("depth_mm", number), ("force_n", vector),
        ("torque_nmm", vector), ("contact_area_mm2", number), ("light_way", pa.string()), ("image_way", pa.string()),
        ("iterations", pa.int32()), ("min_jacobian", number), ("max_penetration_mm", number), ("force_balance", number),
        ("contact_mask", picture), ("displacements_mm", pa.list_(pa.float32())),
    ]  # fmt: skip
    if marked:
        fields += [(name, pa.list_(pa.list_(number))) for name in MARKERS]
    touched = [name for name in TOUCH_COLUMNS if name in touch]
    fields += [(name, number if name.startswith("max_") else pa.list_(pa.list_(number))) for name in touched]
    for judgement in judgements:
        fields += [(f"{judgement.profile}_{key}", number) for key in NUMBERS]
        fields += [(f"{judgement.profile}_{key}", pa.string()) for key in WORDS]
        fields += [(f"{judgement.profile}_weak", pa.bool_())]
    return pa.schema(fields)


def _row(frame: SimulatedFrame) -> dict[str, Any]:
    state = frame.truth.state
    moved, mask = frame.labels.displacements_mm, frame.labels.contact_mask
    return truth_row(frame) | {
        "file": frame_file(frame.truth.index), "x_mm": state.x_mm, "y_mm": state.y_mm,
        "gap_mm": state.gap_mm if state.gap_mm is not None else math.nan,
        "contact_mask": {"bytes": _png(mask), "path": None} if mask is not None else None,
        "displacements_mm": moved.ravel() if moved is not None else None,
    }  # fmt: skip


def _marker_row(frame: SimulatedFrame) -> dict[str, Any]:
    labels = {name: getattr(frame.labels, name) for name in MARKERS}
    return {name: each.tolist() if each is not None else None for name, each in labels.items()}


def _touch_row(frame: SimulatedFrame, settings: TaxelSettings) -> dict[str, Any]:
    touch = frame.labels.touch
    found = touch_columns(touch, settings) if touch is not None else {}
    return {name: each.tolist() if isinstance(each, np.ndarray) else each for name, each in found.items()}


def _png(mask: np.ndarray[Any, np.dtype[np.bool_]]) -> bytes:
    return bytes(cv2.imencode(".png", mask.astype(np.uint8) * 255)[1].tobytes())
