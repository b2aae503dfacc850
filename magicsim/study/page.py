"""The page of a study: everything in one HTML file that needs no network, no script and no other file."""

import math
import re
from dataclasses import dataclass

from markupsafe import Markup

from magicsim.report.templates import page_template
from magicsim.report.text import MISSING, number
from magicsim.study.protocol import Study
from magicsim.study.result import Cell, Column, Matrix, StudyResult, Table

UNIT_ENDS = {"mm": "mm", "n": "N", "deg": "deg"}
"""Ends of headline keys that are units, as a page writes them."""
MANY = 13
"""Columns of a matrix from which its cells are small."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownTable:
    """A table as the page shows it."""

    title: str
    note: str
    heads: list[str]
    rows: list[list[str]]
    left_out: int
    """Rows that only the files have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownCell:
    """A cell of a matrix."""

    count: int
    share: float
    """Of its row, 0 to 1."""
    right: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownMatrix:
    """A matrix as the page shows it."""

    title: str
    note: str
    answers: tuple[str, ...]
    rows: list[tuple[str, list[ShownCell]]]
    is_small: bool


def render_page(study: Study, found: StudyResult) -> str:
    """A whole HTML document."""
    config = study.config
    return page_template("study.html.jinja", "magicsim.study", "magicsim.report").render(
        title=f"Study: {config.kind.replace('-', ' ')}",
        facts={**found.facts, "Seed": str(config.seed)},
        headline={headed(name): shown(value) for name, value in found.headline.items()},
        tables=[shown_table(each) for each in found.tables],
        matrices=[shown_matrix(each) for each in found.matrices],
        figures=[(each.title, each.note, Markup(each.svg)) for each in found.figures],
        notes=found.notes,
    )


def shown_table(table: Table) -> ShownTable:
    """A table's cells as text."""
    rows = [[shown(row.get(each.name), each.digits) for each in table.columns] for row in table.rows[: table.shown]]
    heads = [_head(each) for each in table.columns]
    left_out = max(0, len(table.rows) - table.shown)
    return ShownTable(title=table.title, note=table.note, heads=heads, rows=rows, left_out=left_out)


def shown_matrix(matrix: Matrix) -> ShownMatrix:
    """A matrix with shares of each row."""
    totals = matrix.counts.sum(1)
    rows = [
        (
            truth,
            [
                ShownCell(count=int(count), share=float(count / total) if total else 0.0, right=bool(right))
                for count, right in zip(counts, rights, strict=True)
            ],
        )
        for truth, counts, rights, total in zip(matrix.truths, matrix.counts, matrix.right, totals, strict=True)
    ]
    return ShownMatrix(
        title=matrix.title, note=matrix.note, answers=matrix.answers, rows=rows, is_small=len(matrix.answers) >= MANY
    )


def shown(value: Cell, digits: int = 3) -> str:
    """A value as text; numbers below what the digits show get three significant ones."""
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        small = math.isfinite(value) and 0 < abs(value) < 10.0**-digits
        return f"{value:.2e}" if small else number(value, digits)
    return str(value)


def in_words(name: str) -> str:
    """A key as words, such as `error of x mm`; points within numbers stay."""
    return re.sub(r"(?<!\d)\.|\.(?!\d)", " ", name.replace("_", " "))


def headed(name: str) -> str:
    """A key of the headline as words, its unit in brackets where the key ends with one."""
    head, _, end = name.rpartition("_")
    is_unit = end in UNIT_ENDS and head != "" and not head[-1].isdigit()
    return f"{in_words(head)} [{UNIT_ENDS[end]}]" if is_unit else in_words(name)


def _head(column: Column) -> str:
    title = column.title or in_words(column.name.removesuffix(f"_{column.unit}") if column.unit else column.name)
    return f"{title} [{column.unit}]" if column.unit else title
