"""Rows of a dataset from recorded frames: one table of a simulated dataset's columns for a few frames at a time."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import Any

import cv2
import pyarrow as pa

from magicsim.dataset.columns import recorded_columns
from magicsim.dataset.features import Column, schema_of_columns
from magicsim.dataset.shard import ROWS_A_GROUP
from magicsim.detectors.frame import Frame
from magicsim.errors import FrameError
from magicsim.real.description import TruthRules
from magicsim.real.sequence import RealFrame
from magicsim.real.truth import truth_of


def table_columns(*, contact_is_told: bool) -> list[Column]:
    """Columns of a dataset of recorded frames; `contact`, which has no word for what nobody knows, where it is told."""
    return [each for each in recorded_columns() if contact_is_told or each.name != "contact"]


def tables(rows: Iterable[Mapping[str, Any]], columns: list[Column]) -> Iterator[pa.Table]:
    """Rows in tables of the size of a row group."""
    schema, left = schema_of_columns(columns), iter(rows)
    while batch := list(islice(left, ROWS_A_GROUP)):
        arrays = [
            pa.array([row[each.name] if row.get(each.name) is not None else each.empty for row in batch], each.arrow)
            for each in columns
        ]
        yield pa.Table.from_arrays(arrays, schema=schema)


def frame_row(
    frame: RealFrame, rules: TruthRules, told: frozenset[str], *, step: int, first_s: float
) -> dict[str, Any]:
    """What one frame gives of the columns.

    Args:
        frame: The frame.
        rules: How classes follow from labels.
        told: Which labels there are at all.
        step: Its place in the episode, references first.
        first_s: Time of the episode's first frame [s].
    """
    labels = frame.labels
    common = {
        "image": png(frame.image),
        "step": step,
        "time_s": labels["time_s"] - first_s,
        "is_reference": frame.is_reference,
        "flashlight": bool(labels["flashlight"]),
    }
    if frame.is_reference:
        return common | {"frame_class": "", "contact": False, "force_n": [0.0] * 3, "depth_mm": 0.0}
    truth = truth_of(labels, rules, told, name=frame.name)
    return common | {
        "frame_class": str(truth.frame_class or ""),
        "gap_mm": truth.gap_mm,
        "contact": truth.contact,
        "depth_mm": truth.depth_mm,
        "force_n": labels["force_n"],
        "torque_nmm": labels["torque_nmm"],
        "contact_area_mm2": labels["contact_area_mm2"],
        "object_position_mm": labels["place_mm"],
        "twist_deg": labels["twist_deg"],
    }


def png(image: Frame) -> dict[str, Any]:
    """An image column's value.

    Raises:
        FrameError: It cannot be coded.
    """
    good, content = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    if not good:
        msg = "a frame cannot be stored as PNG"
        raise FrameError(msg)
    return {"bytes": content.tobytes(), "path": None}
