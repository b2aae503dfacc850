"""Labels of recorded frames from a CSV file, and what they say as simulated frames have it: gap, contact, class."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.dataset.real.description import Description, LabelColumns, Scales, TruthRules
from magicsim.errors import NAME_LENGTH, ConfigError, shortened, unknown_choice
from magicsim.frame_class import FrameClass, classify_frame

NUMBERS = ("time_s", "gap_mm", "depth_mm", "twist_deg", "contact_area_mm2")
VECTORS = ("place_mm", "force_n", "torque_nmm")
FLAGS = ("is_reference", "contact", "flashlight")
TEXTS = ("episode", "frame_class", "object_kind")
MOST_BYTES = 500_000_000
Row = dict[str, Any]
"""Labels by the names of `LabelColumns`: a number or NaN, a list of three, a flag or None, a text or an empty one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelTable:
    """All rows of one CSV file."""

    path: Path
    rows: tuple[Row, ...]
    known: frozenset[str]
    """Names of `LabelColumns` that the file has."""


def read_labels(path: Path, description: Description, *, needs_images: bool) -> LabelTable:
    """Reads a CSV file.

    Args:
        path: With a heading.
        description: Names of its columns, and factors.
        needs_images: Whether every row has to name an image.

    Raises:
        ConfigError: No such file, a column that it lacks, or a cell that is not what its column holds.
    """
    columns, scale = description.columns, description.scale
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            msg = f"labels '{path}' has {size / 1e6:.0f} MB: at most {MOST_BYTES / 1e6:.0f} MB are allowed"
            raise ConfigError(msg)
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            heading = [name.strip() for name in reader.fieldnames or ()]
            reader.fieldnames = heading
            wanted = _wanted(columns, needs_images=needs_images)
            for field, name in wanted:
                if name not in heading:
                    raise ConfigError(f"{path}: {unknown_choice(f'column of columns.{field}', name, heading)}")
            rows = tuple(_row(path, number, cells, columns, scale) for number, cells in enumerate(reader, 2))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        msg = (
            f"labels '{path}' cannot be read: {getattr(error, 'strerror', None) or error}; must be a CSV file in UTF-8"
        )
        raise ConfigError(msg) from None
    if not rows:
        msg = f"labels '{path}' has a heading and no rows; must have one for each frame"
        raise ConfigError(msg)
    return LabelTable(path=path, rows=rows, known=frozenset(field for field, _ in wanted))


def at_time(labels: LabelTable, time_s: float, *, most_gap_s: float) -> Row:
    """Labels at a time: numbers linearly between the rows around it, the rest from the nearer one.

    Args:
        labels: With times that do not fall.
        time_s: Of the frame, on the labels' clock [s].
        most_gap_s: Rows farther away say nothing [s].
    """
    times = np.array([row["time_s"] for row in labels.rows])
    after = int(np.searchsorted(times, time_s))
    around = [labels.rows[place] for place in (after - 1, after) if 0 <= place < len(times)]
    close = [row for row in around if abs(row["time_s"] - time_s) <= most_gap_s]
    if not close:
        return nothing()
    nearest = min(close, key=lambda row: abs(row["time_s"] - time_s))
    if len(close) == 1:
        return nearest | {"time_s": time_s}
    first, second = close
    share = (time_s - first["time_s"]) / max(second["time_s"] - first["time_s"], 1e-12)
    row = dict(nearest)
    for name in (*NUMBERS, *VECTORS):
        mixed = (1 - share) * np.array(first[name], float) + share * np.array(second[name], float)
        row[name] = mixed.tolist()
    return row | {"time_s": time_s}


def check_times(labels: LabelTable) -> None:
    """Refuses labels of a video without times, or with times that fall.

    Raises:
        ConfigError: It says which row.
    """
    if "time_s" not in labels.known:
        msg = f"columns.time_s is missing: labels '{labels.path}' of a video need the times that they belong to"
        raise ConfigError(msg)
    times = np.array([row["time_s"] for row in labels.rows])
    wrong = np.flatnonzero(~np.isfinite(times) | np.concatenate([[False], np.diff(times) < 0]))
    if len(wrong):
        msg = f"{labels.path}, line {wrong[0] + 2}: time_s is missing or falls; must rise from row to row"
        raise ConfigError(msg)


def nothing() -> Row:
    """Labels of a frame of which nothing is known."""
    return (
        dict.fromkeys(NUMBERS, math.nan)
        | {name: [math.nan] * 3 for name in VECTORS}
        | dict.fromkeys(FLAGS)
        | dict.fromkeys(TEXTS, "")
        | {"image": ""}
    )


def _wanted(columns: LabelColumns, *, needs_images: bool) -> list[tuple[str, str]]:
    """Fields of a description and the columns of the file that they name."""
    wanted = []
    for field in LabelColumns.model_fields:
        named = getattr(columns, field)
        if named is None or (field == "image" and not needs_images):
            continue
        wanted += [(field, name) for name in ((named,) if isinstance(named, str) else named)]
    return wanted


def _row(path: Path, number: int, cells: dict[str, str | None], columns: LabelColumns, scale: Scales) -> Row:
    where, row = f"{path}, line {number}", nothing()

    def text(name: str) -> str:
        return (cells.get(name) or "").strip()

    row["image"] = text(columns.image)
    for field in TEXTS:
        if (name := getattr(columns, field)) is not None:
            row[field] = text(name)
    for field in FLAGS:
        if (name := getattr(columns, field)) is not None:
            row[field] = _flag(where, name, text(name))
    for field in NUMBERS:
        if (name := getattr(columns, field)) is not None:
            row[field] = getattr(scale, field) * _number(where, name, text(name))
    for field in VECTORS:
        if (named := getattr(columns, field)) is not None:
            row[field] = _vector(where, named, text, getattr(scale, field))
    return row


def _vector(where: str, named: str | tuple[str, ...], text: Any, factor: Any) -> list[float]:  # noqa: ANN401 - of pydantic
    """Three numbers: of one column that along z, of two those along x and y."""
    factors = factor if isinstance(factor, tuple) else (factor,) * 3
    if isinstance(named, str):
        return [math.nan, math.nan, factors[2] * _number(where, named, text(named))]
    values = [_number(where, name, text(name)) for name in named]
    return [one * each for one, each in zip(factors, [*values, *[math.nan] * (3 - len(values))], strict=True)]


def _flag(where: str, name: str, text: str) -> bool | None:
    known = {"1": True, "true": True, "0": False, "false": False, "": None}
    if text.lower() not in known:
        msg = f"{where}: {name} = '{shortened(text, NAME_LENGTH)}' is not allowed: must be 0, 1, true, false or empty"
        raise ConfigError(msg)
    return known[text.lower()]


def _number(where: str, name: str, text: str) -> float:
    if not text or text.lower() == "nan":
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.inf
    if not math.isfinite(value):
        msg = f"{where}: {name} = '{shortened(text, NAME_LENGTH)}' is not allowed: must be a finite number or empty"
        raise ConfigError(msg)
    return value


def force_size(force_n: list[float]) -> float:
    """Size of a force, of which only the component along z may be known [N]; NaN where nothing is."""
    known = np.array(force_n, float)
    return float(np.linalg.norm(known[~np.isnan(known)])) if not np.isnan(known).all() else math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTruth:
    """State of one frame, as far as it is known."""

    gap_mm: float
    """NaN without an object and where nobody knows."""
    depth_mm: float
    """NaN where nobody knows."""
    contact: bool | None
    frame_class: FrameClass | None
    """None where it is not scored."""


def truth_of(row: Row, rules: TruthRules, known: frozenset[str], *, name: str = "frame") -> RealTruth:
    """The state that labels tell.

    A class that is given counts. Else a gap decides, as for simulated frames; else a depth; else contact, where a
    touch of unknown depth counts as one; else an outside light.

    Args:
        row: Labels of the frame.
        rules: What follows from what.
        known: Which labels the file has at all: an empty gap then means that there is no object.
        name: What messages call the frame.

    Raises:
        ConfigError: A word that is no class.
    """
    gap_mm, depth_mm, force_n = row["gap_mm"], row["depth_mm"], force_size(row["force_n"])
    if math.isnan(gap_mm) and depth_mm > 0:
        gap_mm = -depth_mm
    if math.isnan(depth_mm) and not math.isnan(gap_mm):
        depth_mm = max(0.0, -gap_mm)
    contact: bool | None = row["contact"]
    if contact is None and not math.isnan(force_n):
        contact = force_n > rules.contact_n
    if contact is None and not math.isnan(gap_mm):
        contact = gap_mm < 0
    if contact is None and not math.isnan(depth_mm):
        contact = depth_mm > 0
    frame_class: FrameClass | None
    if "frame_class" in known:
        frame_class = _given(row["frame_class"], rules, name)
    elif not math.isnan(gap_mm) or "gap_mm" in known:
        frame_class = classify_frame(
            gap_mm=None if math.isnan(gap_mm) else gap_mm,
            force_n=float(bool(contact)),
            light_on=bool(row["flashlight"]),
        )
    elif contact:
        frame_class = FrameClass.CONTACT
    elif row["flashlight"]:
        frame_class = FrameClass.LIGHT
    else:
        frame_class = FrameClass(rules.without_contact) if contact is False and rules.without_contact else None
    return RealTruth(gap_mm=gap_mm, depth_mm=depth_mm, contact=contact, frame_class=frame_class)


def _given(word: str, rules: TruthRules, name: str) -> FrameClass | None:
    """Class that a column gives; None for an empty text."""
    meant = rules.classes.get(word, word)
    if meant and meant not in list(FrameClass):
        msg = f"'{name}': {unknown_choice('class', word, FrameClass)}; truth.classes translates other words"
        raise ConfigError(msg)
    return FrameClass(meant) if meant else None
