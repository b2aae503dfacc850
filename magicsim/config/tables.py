"""The one reader of tables of comma-separated values: whatever is not clear about a cell is one line that names it.

Cells are separated by commas, numbers have a decimal point, the first line names the columns, and every further one has
as many cells as that. An empty cell is unknown.
"""

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from magicsim.errors import NAME_LENGTH, ConfigError, shortened

MOST_BYTES = 500_000_000
"""Largest table."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
_FLAGS = {"1": True, "true": True, "0": False, "false": False, "": None}
_OTHER_DELIMITERS = {";": "';'", "\t": "tabs", "|": "'|'", " ": "spaces"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """Cells of one line by the names of their columns."""

    number_in_file: int
    """1 is the first line of the file."""
    where: str
    """Table and line, for messages."""
    cells: Mapping[str, str]

    def text(self, name: str) -> str:
        """What stands there, an empty text for nothing."""
        return self.cells[name].strip()

    def number(self, name: str) -> float:
        """A number, NaN where the cell is empty or says `nan`; `ConfigError` for all else or what is infinite."""
        text = self.text(name)
        if not text or text.lower() == "nan":
            return math.nan
        value = float(text) if _NUMBER.fullmatch(text) else math.inf
        if not math.isfinite(value):
            allowed = "a finite number or empty" + (", with a decimal point" if "," in text else "")
            raise self._not_allowed(name, allowed)
        return value

    def flag(self, name: str) -> bool | None:
        """Whether it says 1 or true, None where it is empty; `ConfigError` for anything but 0, 1, true and false."""
        text = self.text(name).lower()
        if text not in _FLAGS:
            raise self._not_allowed(name, "0, 1, true, false or empty")
        return _FLAGS[text]

    def certain_flag(self, name: str) -> bool:
        """Whether it says 1; `ConfigError` for anything but 0 and 1."""
        if self.text(name) not in {"0", "1"}:
            raise self._not_allowed(name, "0 or 1")
        return self.text(name) == "1"

    def _not_allowed(self, name: str, allowed: str) -> ConfigError:
        text = shortened(self.text(name), NAME_LENGTH)
        return ConfigError(f"{self.where}: {name} = '{text}' is not allowed: must be {allowed}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table as it stands in its file."""

    path: Path
    heading: tuple[str, ...]
    """Names of the columns; none in an empty file."""
    rows: tuple[tuple[int, list[str]], ...]
    """Number of the line and its cells, lines without any left out."""

    def lines(self, names: Iterable[str]) -> Iterator[Line]:
        """The lines after the heading, of which some columns are used.

        `ConfigError` where such a column is there twice, or a line has more or fewer cells than the heading.
        """
        for name in names:
            if self.heading.count(name) > 1:
                raise ConfigError(
                    f"{self.path}: {self.heading.count(name)} columns are called '{shortened(name, NAME_LENGTH)}'; "
                    "must be one"
                )
        for number, cells in self.rows:
            where = f"{self.path}, line {number}"
            if len(cells) != len(self.heading):
                more = "; a number has a decimal point" if len(cells) > len(self.heading) else ""
                raise ConfigError(f"{where}: {len(cells)} cells; must be {len(self.heading)}, as in the heading{more}")
            yield Line(number_in_file=number, where=where, cells=dict(zip(self.heading, cells, strict=True)))

    def check_delimiter(self) -> None:
        """Refuses (`ConfigError`) a heading of one cell that has another delimiter, for which names are not found."""
        if self.heading and self.heading[0].startswith("#"):
            raise ConfigError(f"{self.path}: the first line is a comment; must be the names of the columns")
        for mark, name in _OTHER_DELIMITERS.items():
            if len(self.heading) == 1 and mark in self.heading[0]:
                raise ConfigError(f"{self.path}: cells are separated by {name}; must be commas, with decimal points")


def read_table(path: Path) -> Table:
    """Reads a table; `ConfigError` where it is unreadable, too large, not UTF-8, or its quotes do not close."""
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise ConfigError(f"'{path}' has {size / 1e6:.0f} MB: at most {MOST_BYTES / 1e6:.0f} MB are allowed")
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file, skipinitialspace=True, strict=True)
            heading = tuple(name.strip() for name in next(reader, ()))
            rows = tuple((reader.line_num, cells) for cells in reader if cells)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"'{path}' cannot be read: {reason}; must be a CSV file in UTF-8") from None
    return Table(path=path, heading=heading, rows=rows)
