"""What a study gives: tables, matrices of answers, figures, and a few numbers that sum it up."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Cell = float | int | str | bool | None
Row = Mapping[str, Cell]


def column_of(rows: Sequence[Row], name: str) -> list[float]:
    """A column of numbers, NaN where a row has none."""
    return [float(each) if isinstance(each := row.get(name), int | float) else math.nan for row in rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column of a table."""

    name: str
    """Key of the rows; ends with its unit where it has one, such as `error_mm`."""
    title: str = ""
    """Head on the page; the name in words by default."""
    unit: str = ""
    digits: int = 3
    """Decimals on the page; files have all of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of the result: a Parquet file, a list in the JSON, a table on the page."""

    name: str
    """Name of the file, without its end."""
    title: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    note: str = ""
    """What a reader has to know to read it."""
    shown: int = 60
    """Rows on the page at most; files have all of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Matrix:
    """How often each true answer (rows) was given as which (columns)."""

    name: str
    title: str
    truths: tuple[str, ...]
    answers: tuple[str, ...]
    counts: npt.NDArray[np.int64]
    """Shape (truths, answers)."""
    right: npt.NDArray[np.bool_]
    """Which of them count as right, of the same shape."""
    note: str = ""

    def as_table(self) -> Table:
        """The matrix as a table of files, a row a pair of truth and answer."""
        rows: tuple[Row, ...] = tuple(
            {"truth": truth, "answer": answer, "count": int(self.counts[place]), "right": bool(self.right[place])}
            for row, truth in enumerate(self.truths)
            for column, answer in enumerate(self.answers)
            for place in [(row, column)]
        )
        columns = tuple(Column(name=name) for name in ("truth", "answer", "count", "right"))
        return Table(name=self.name, title=self.title, columns=columns, rows=rows, note=self.note)


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A drawing of the page."""

    name: str
    title: str
    svg: str
    """An `svg` element, see `magicsim.report.drawing.to_svg`."""
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult:
    """All that a study found."""

    headline: Mapping[str, Cell]
    """Few numbers that sum it up, with units in their names."""
    tables: tuple[Table, ...]
    matrices: tuple[Matrix, ...] = ()
    figures: tuple[Figure, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
    """What it was made of, in words: frames, presses, units."""
    notes: tuple[str, ...] = ()
    """Sentences: what was left out against the protocol, what a number rests on."""
