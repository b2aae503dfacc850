"""Labels of recorded frames from a CSV file, and what they say as simulated frames have it: gap, contact, class."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.config.tables import Line, read_table
from magicsim.dataset.real.description import Description, LabelColumns, Scales, TruthRules
from magicsim.detectors.source import by_number, is_numbered
from magicsim.detectors.video import Remark
from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import LIGHT_TOUCH, FrameClass, classify_frame, scored_class
from magicsim.judge.plausible import force_size

NUMBERS = ("time_s", "gap_mm", "depth_mm", "twist_deg", "contact_area_mm2")
VECTORS = ("place_mm", "force_n", "torque_nmm")
FLAGS = ("is_reference", "contact", "flashlight")
TEXTS = ("episode", "frame_class", "object_kind")
CONTACT_LABELS = frozenset({"contact", "force_n", "depth_mm", "gap_mm"})
"""Labels that tell of a contact."""
Row = dict[str, Any]
"""Labels by the names of `LabelColumns`: a number or NaN, a list of three, a flag or None, a text or an empty one. And
`line`, the number of its line, `force_parts`, how many columns its force has, and whether there are labels at all."""


@dataclass(frozen=True, kw_only=True)
class LabelTable:
    """All rows of one CSV file."""

    path: Path
    rows: tuple[Row, ...]
    known: frozenset[str]
    """Names of `LabelColumns` that the file has."""

    @cached_property
    def times_s(self) -> Array:
        """Times of the rows [s], shape (rows,)."""
        return np.array([row["time_s"] for row in self.rows], np.float64)


def read_labels(path: Path, description: Description, *, needs_images: bool) -> LabelTable:
    """Reads a CSV file.

    `ConfigError` without such a file, for a column that it lacks or has twice, another number of cells than headings,
    or a cell that is not what its column holds.
    """
    table = read_table(path)
    wanted = _wanted(description.columns, needs_images=needs_images)
    for field, name in wanted:
        if name not in table.heading:
            table.check_delimiter()
            raise ConfigError(f"{path}: {unknown_choice(f'column of columns.{field}', name, table.heading)}")
    names = [name for _, name in wanted]
    rows = tuple(_row(line, description.columns, description.scale, names) for line in table.lines(names))
    if not rows:
        raise ConfigError(f"labels '{path}' has a heading and no rows; must have one for each frame")
    return LabelTable(path=path, rows=rows, known=frozenset(field for field, _ in wanted))


def at_time(labels: LabelTable, time_s: float, *, most_gap_s: float) -> Row:
    """Labels at a time: numbers linearly between the rows around it, the rest from the nearer one.

    A number that one of the two does not have is the nearer one's too. Rows must rise in time, and those farther away
    than `most_gap_s` say nothing.
    """
    after = int(np.searchsorted(labels.times_s, time_s))
    around = [labels.rows[place] for place in (after - 1, after) if 0 <= place < len(labels.rows)]
    close = [row for row in around if abs(row["time_s"] - time_s) <= most_gap_s]
    if not close:
        return nothing() | {"is_there": False}
    nearest = min(close, key=lambda row: abs(row["time_s"] - time_s))
    if len(close) == 1:
        return nearest | {"time_s": time_s}
    first, second = close
    share = (time_s - first["time_s"]) / max(second["time_s"] - first["time_s"], 1e-12)
    row = dict(nearest)
    for name in (*NUMBERS, *VECTORS):
        one, two, near = (np.array(each[name], float) for each in (first, second, nearest))
        if name == "twist_deg":  # the short way round
            two = one + (two - one + 180) % 360 - 180
        row[name] = np.where(np.isnan(one + two), near, (1 - share) * one + share * two).tolist()
    return row | {"time_s": time_s}


def check_times(labels: LabelTable) -> None:
    """Refuses (`ConfigError`) labels of a video without times, or with times that fall."""
    if "time_s" not in labels.known:
        msg = f"columns.time_s is missing: labels '{labels.path}' of a video need the times that they belong to"
        raise ConfigError(msg)
    times = labels.times_s
    wrong = np.flatnonzero(~np.isfinite(times) | np.concatenate([[False], np.diff(times) < 0]))
    if len(wrong):
        line = labels.rows[int(wrong[0])]["line"]
        raise ConfigError(f"{labels.path}, line {line}: time_s is missing or falls; must rise from row to row")


def nothing() -> Row:
    """Labels of a frame of which nothing is known."""
    return (
        dict.fromkeys(NUMBERS, math.nan)
        | {name: [math.nan] * 3 for name in VECTORS}
        | dict.fromkeys(FLAGS)
        | dict.fromkeys(TEXTS, "")
        | {"image": "", "line": 0, "force_parts": len("xyz"), "is_there": True}
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


def _row(line: Line, columns: LabelColumns, scale: Scales, names: Collection[str]) -> Row:
    row = nothing() | {"line": line.number_in_file}
    row["image"] = line.text(columns.image) if columns.image in names else ""
    for field in (*TEXTS, *FLAGS, *NUMBERS, *VECTORS):
        if (named := getattr(columns, field)) is None:
            continue
        if field in TEXTS:
            row[field] = line.text(named)
        elif field in FLAGS:
            row[field] = line.flag(named)
        elif field in NUMBERS:
            row[field] = getattr(scale, field) * line.number(named)
        else:
            row[field] = _vector(line, named, getattr(scale, field))
    if isinstance(columns.force_n, str):
        row["force_parts"] = 1
    return row


def _vector(line: Line, named: str | tuple[str, ...], factor: Any) -> list[float]:  # noqa: ANN401 - of pydantic
    """Three numbers: of one column that along z, of two those along x and y."""
    factors = factor if isinstance(factor, tuple) else (factor,) * 3
    if isinstance(named, str):
        return [math.nan, math.nan, factors[2] * line.number(named)]
    values = [line.number(name) for name in named]
    return [one * each for one, each in zip(factors, [*values, *[math.nan] * (3 - len(values))], strict=True)]


def is_empty(row: Row) -> bool:
    """Whether labels say nothing at all."""
    numbers = [row[name] for name in NUMBERS if name != "time_s"] + [each for name in VECTORS for each in row[name]]
    rest = [*(row[name] for name in FLAGS), *(row[name] or None for name in TEXTS)]
    return all(map(math.isnan, numbers)) and all(each is None for each in rest)


def size_of_force(row: Row, felt_n: float) -> float:
    """Size of the force of a row [N], NaN where it is not known (`magicsim.judge.plausible.force_size`)."""
    return force_size(row["force_n"][-row["force_parts"] :], felt_n=felt_n)


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
    touch of unknown depth counts as one; else an outside light. What is not known is never no contact: an empty gap
    means no object only where `known` labels have gaps, and force and contact, as far as they have such columns, do
    not leave a touch open. `ConfigError` for a word that is no class.
    """
    gap_mm, depth_mm, force_n = row["gap_mm"], row["depth_mm"], size_of_force(row, rules.contact_n)
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
    is_told = contact is False or (contact is None and not known & {"force_n", "contact"})
    is_without_object = math.isnan(gap_mm) and "gap_mm" in known and row["is_there"] and is_told
    if is_without_object:
        contact = False
    frame_class: FrameClass | None
    if "frame_class" in known:
        word = rules.classes.get(row["frame_class"], row["frame_class"])
        if word and word not in {LIGHT_TOUCH, *FrameClass}:
            unknown = unknown_choice("class", row["frame_class"], FrameClass)
            raise ConfigError(f"'{name}': {unknown}; truth.classes translates other words")
        frame_class = scored_class(word)  # none for an empty text and for a light touch
    elif not math.isnan(gap_mm) or is_without_object:
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


Entry = tuple[Path, Row]
"""Image and its labels."""


def in_order(entries: Sequence[Entry], table: Path, remark: Remark) -> tuple[Entry, ...]:
    """Labelled images as their rows stand, or as times and names say that they were taken.

    Rows that fall in time are put in its order where names have that order too, or where all of them stand the newest
    first. Rows without times that stand in the order of texts (`frame_10` before `frame_2`), or the newest first, are
    put in the order of the numbers in their names. Every episode is looked at by itself and keeps its places.

    `ConfigError` where times fall and nothing says what is meant; `remark` hears what was changed, and of rows in no
    order of names.
    """
    ordered = list(entries)
    for episode in dict.fromkeys(row["episode"] for _, row in entries):
        places = [place for place, (_, row) in enumerate(entries) if row["episode"] == episode]
        mine = [entries[place] for place in places]
        for place, each in zip(places, _episode_in_order(mine, table, remark), strict=True):
            ordered[place] = each
    return tuple(ordered)


def _episode_in_order(entries: list[Entry], table: Path, remark: Remark) -> list[Entry]:
    is_named = is_numbered([path.stem for path, _ in entries])
    named = sorted(entries, key=lambda each: by_number(str(each[0]))) if is_named else None
    times = np.array([row["time_s"] for _, row in entries], float)
    known = times[~np.isnan(times)]
    if len(known):
        falls = np.flatnonzero(np.diff(known) < 0)
        if not len(falls):
            return entries
        timed = [entries[place] for place in np.argsort(times, kind="stable")]
        if len(known) == len(times) and timed in (named, entries[::-1]):
            remark(f"rows of '{table.name}' are put in the order of their times")
            return timed
        line = entries[int(np.flatnonzero(~np.isnan(times))[falls[0] + 1])][1]["line"]
        raise ConfigError(
            f"{table}, line {line}: time_s falls; must rise from row to row, or name columns.episode where the clock "
            "begins anew"
        )
    if named is None or entries == named:
        return entries
    if entries in (sorted(entries, key=lambda each: str(each[0])), named[::-1]):
        remark(
            f"rows of '{table.name}' are put in the order of the numbers in the names of their images, "
            f"'{named[0][0].name}' first"
        )
        return named
    remark(f"rows of '{table.name}' are in another order than the numbers in the names of their images: theirs is kept")
    return entries
