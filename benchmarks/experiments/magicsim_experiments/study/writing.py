"""The result of a study as files: Parquet a table, one JSON of all, and the page."""

import json
from collections.abc import Iterable
from typing import Any

import pyarrow as pa

from magicsim.config.documents import without_nan
from magicsim.folder.ledger import Ledger
from magicsim.folder.parquet import parquet_bytes
from magicsim_experiments.study.folder import REPORT, RESULTS, TABLES
from magicsim_experiments.study.page import render_page
from magicsim_experiments.study.protocol import Study
from magicsim_experiments.study.result import StudyResult, Table


def write_result(ledger: Ledger, study: Study, found: StudyResult) -> None:
    """Writes everything that a reader opens.

    Raises:
        OutputError: Somebody else's file has one of the names.
    """
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
