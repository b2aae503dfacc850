"""The result of a study as files: Parquet a table, one JSON of all, and the page."""

import json
import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyarrow as pa
from markupsafe import Markup

from magicsim.config.documents import without_nan
from magicsim.dataset.shard import parquet_bytes
from magicsim.folder.ledger import Ledger
from magicsim.report.text import MISSING, number, page_template
from magicsim_experiments.study.protocol import REPORT, RESULTS, TABLES, Study
from magicsim_experiments.study.result import Cell, Column, StudyResult, Table

UNIT_ENDS = {"mm": "mm", "n": "N", "deg": "deg"}
"""Ends of headline keys that are units, as a page writes them."""
MANY = 13
"""Columns of a matrix from which its cells are small."""


def render_page(study: Study, found: StudyResult) -> str:
    """A whole HTML document."""
    config = study.config
    return page_template("study.html.jinja", "magicsim_experiments.study", "magicsim.report").render(
        title=f"Study: {config.kind.replace('-', ' ')}",
        facts={**found.facts, "Seed": str(config.seed)},
        headline={headed(name): shown(value) for name, value in found.headline.items()},
        tables=found.tables,
        matrices=[(each, each.counts / np.maximum(each.counts.sum(1, keepdims=True), 1)) for each in found.matrices],
        many=MANY,
        head=head,
        shown=shown,
        figures=[(each.title, each.note, Markup(each.svg)) for each in found.figures],
        notes=found.notes,
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


def head(column: Column) -> str:
    """Head of a column, its unit in brackets."""
    title = column.title or in_words(column.name.removesuffix(f"_{column.unit}") if column.unit else column.name)
    return f"{title} [{column.unit}]" if column.unit else title


def write_result(ledger: Ledger, study: Study, found: StudyResult) -> None:
    """Writes everything that a reader opens."""
    for table in all_tables(found):
        ledger.place(f"{TABLES}/{table.name}.parquet", table_parquet(table))
    text = json.dumps(result_dict(study, found), allow_nan=False, indent=1)
    ledger.place(RESULTS, (text + "\n").encode())
    ledger.place(REPORT, render_page(study, found).encode())


def all_tables(found: StudyResult) -> list[Table]:
    """Tables of a result, its matrices among them."""
    return [*found.tables, *(matrix.as_table() for matrix in found.matrices)]


def result_dict(study: Study, found: StudyResult) -> dict[str, Any]:
    """The result as JSON has it; what is not a number is null."""
    return {
        "study": study.config.kind,
        "seed": study.config.seed,
        "headline": without_nan(found.headline),
        "facts": dict(found.facts),
        "tables": {table.name: without_nan(list(table.rows)) for table in all_tables(found)},
        "notes": list(found.notes),
    }


def table_parquet(table: Table) -> bytes:
    """A table as a Parquet file, title and unit of every column in its metadata."""
    fields = [
        pa.field(each.name, _kind(row.get(each.name) for row in table.rows), metadata=_about(each.title, each.unit))
        for each in table.columns
    ]
    rows = [{each.name: row.get(each.name) for each in table.columns} for row in table.rows]
    return parquet_bytes(pa.Table.from_pylist(rows, schema=pa.schema(fields)))


def _kind(values: Iterable[object]) -> pa.DataType:
    present = [value for value in values if value is not None]
    if any(isinstance(value, float) for value in present) or not present:
        return pa.float64()
    return pa.array(present).type


def _about(title: str, unit: str) -> dict[str, str] | None:
    about = {name: value for name, value in (("title", title), ("unit", unit)) if value}
    return about or None
