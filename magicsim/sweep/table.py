"""The results of a sweep as one table: a row a design, value and interval of every measure."""

import csv
import io
from collections.abc import Sequence

import pyarrow as pa

from magicsim.folder.parquet import parquet_bytes
from magicsim.sweep.judging.measures import described
from magicsim.sweep.judging.quality import Quality
from magicsim.sweep.result import DesignResult

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""How a text begins that spreadsheets compute."""
Row = dict[str, float | int | str | bool | None]


def rows_of(results: Sequence[DesignResult], front: Sequence[bool]) -> list[Row]:
    """One row a design.

    Args:
        results: Of one sweep.
        front: Whether each is in the Pareto front.
    """
    rows = []
    for result, in_front in zip(results, front, strict=True):
        cell = result.block.cell_mm or (None, None, None)
        row: Row = {"design": result.index, "is_extra": result.is_extra, "in_front": bool(in_front), **result.values}
        row |= {"room": result.room, "passes": result.passes, **result.drawn}
        row |= {f"resolved_cell_{axis}_mm": edge for axis, edge in zip("xyz", cell, strict=True)}
        row["height_mm"] = result.block.height_mm
        for name, found in result.measures.items():
            row |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high, f"{name}_note": found.note}
        row["seconds"] = result.seconds
        rows.append(row)
    return rows


def table_csv(rows: Sequence[Row]) -> bytes:
    """The rows as CSV, empty where there is no value; text that a spreadsheet would take for a formula stays text."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, _columns(rows), lineterminator="\n", restval="")
    writer.writeheader()
    writer.writerows({key: _cell(value) for key, value in row.items()} for row in rows)
    return text.getvalue().encode()


def _cell(value: float | str | None) -> float | str:
    """A cell of CSV: an apostrophe before text that begins as a formula does, as spreadsheets write it themselves."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}" if value.startswith(FORMULA) else value
    return value


def table_parquet(rows: Sequence[Row], quality: Quality) -> bytes:
    """The rows as a Parquet file, unit and meaning of every measure in its columns' metadata."""
    kinds, fields = described(quality), []
    for name in _columns(rows):
        values = [row[name] for row in rows if row.get(name) is not None]
        kind = pa.array(values).type if values else pa.float64()
        kind = pa.float64() if pa.types.is_integer(kind) and name != "design" else kind
        known = kinds.get(name)
        about = {"unit": known.unit, "meaning": known.meaning} if known is not None else None
        fields.append(pa.field(name, kind, metadata=about))
    return parquet_bytes(pa.Table.from_pylist([dict(row) for row in rows], schema=pa.schema(fields)))


def _columns(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row))
