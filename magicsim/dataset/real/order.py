"""Labelled images in the order in which they were taken, by their times or by the numbers in their names."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from magicsim.dataset.real.labels import Row
from magicsim.detectors.source import by_number, is_numbered
from magicsim.detectors.video import Remark
from magicsim.errors import ConfigError

Entry = tuple[Path, Row]
"""Image and its labels."""


def in_order(entries: Sequence[Entry], table: Path, remark: Remark) -> tuple[Entry, ...]:
    """Labelled images as their rows stand, or as times and names say that they were taken.

    Rows that fall in time are put in its order where names have that order too, or where all of them stand the newest
    first. Rows without times that stand in the order of texts (`frame_10` before `frame_2`), or the newest first, are
    put in the order of the numbers in their names. Every episode is looked at by itself and keeps its places.

    Args:
        entries: Images with their labels, in the order of the rows.
        table: Where the labels are, for messages.
        remark: Hears what was changed, and of rows that are in no order of names.

    Raises:
        ConfigError: Times fall and nothing says what is meant.
    """
    ordered = list(entries)
    for episode in dict.fromkeys(row["episode"] for _, row in entries):
        places = [place for place, (_, row) in enumerate(entries) if row["episode"] == episode]
        mine = [entries[place] for place in places]
        for place, each in zip(places, _episode_in_order(mine, table, remark), strict=True):
            ordered[place] = each
    return tuple(ordered)


def _episode_in_order(entries: list[Entry], table: Path, remark: Remark) -> list[Entry]:
    named = _by_name(entries)
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


def _by_name(entries: list[Entry]) -> list[Entry] | None:
    """Entries by the numbers in their names; None where these tell no order."""
    if not is_numbered([path.stem for path, _ in entries]):
        return None
    return sorted(entries, key=lambda each: by_number(str(each[0])))
