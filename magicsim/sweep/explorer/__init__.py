"""The results of a sweep: one table, and one page that needs no network, no server and no other file."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import pyarrow as pa
from markupsafe import Markup

from magicsim.config.documents import each_leaf
from magicsim.dataset.shard import parquet_bytes
from magicsim.errors import visible
from magicsim.report.text import page_template
from magicsim.sweep.measures import SweepQuality, described
from magicsim.sweep.result import DesignResult, finite
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.sweep.verdicts import TrendCheck

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""How a text begins that spreadsheets compute."""
Row = dict[str, float | int | str | bool | None]


def rows_of(results: Sequence[DesignResult], front: Sequence[bool]) -> list[Row]:
    """One row a design."""
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


def _cell(value: float | str | None) -> float | str | None:
    """A cell of CSV: an apostrophe before text that begins as a formula does, as spreadsheets write it themselves."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def table_parquet(rows: Sequence[Row], quality: SweepQuality) -> bytes:
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


UNITS = {"_per_mm": "1/mm", "_mm": "mm", "_mpa": "MPa", "_deg": "°", "_px": "px"}
"""Units by the end of a field's name, the longer end first."""


def render_explorer(
    sweep: SweepConfig,
    results: Sequence[DesignResult],
    *,
    front: Sequence[bool],
    trends: Sequence[TrendCheck],
    failed: Mapping[str, str],
    verdicts: Mapping[str, str],
) -> str:
    """The page."""
    title = f"Design sweep: {len(results)} designs"
    return page_template("explorer.html.jinja", "magicsim.sweep.explorer", "magicsim.report").render(
        title=title,
        subtitle=" by ".join(
            f"{label} ({unit})" if unit else label for label, unit in (field_title(each.field) for each in sweep.swept)
        ),
        data=Markup(script_json(explorer_data(sweep, results, front=front, verdicts=verdicts))),
        trends=trends,
        failed=failed,
        measures=described(sweep.quality),
        signed=signed,
        has_results=bool(results),
    )


def explorer_data(
    sweep: SweepConfig, results: Sequence[DesignResult], *, front: Sequence[bool], verdicts: Mapping[str, str]
) -> dict[str, Any]:
    """What the page's script works on."""
    kinds = described(sweep.quality)
    fields = sorted({name for result in results for name in result.values})
    titles = {name: field_title(name) for name in (*(each.field for each in sweep.swept), *fields)}
    measured = [name for name in sweep.measures if any(name in result.measures for result in results)]
    return {
        "fields": [{"name": name, "label": label, "unit": unit} for name, (label, unit) in titles.items()],
        "measures": [{"name": name, "verdict": verdicts.get(name, "")} | asdict(kinds[name]) for name in measured],
        "objectives": [{"measure": each.measure, "better": each.direction} for each in sweep.objectives],
        "designs": [
            each_leaf(finite(asdict(result)), lambda value: visible(value) if isinstance(value, str) else value)
            | {"front": bool(in_front)}
            for result, in_front in zip(results, front, strict=True)
        ],
        "csv": table_csv(rows_of(results, front)).decode(),
    }  # fmt: skip


def script_json(value: object) -> str:
    """JSON that may stand inside a script element, whatever text it holds."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def signed(value: float, digits: int) -> str:
    """A change with its sign, such as `+1.20`."""
    return f"{value:+.{digits}f}".replace("-", "\u2212")


def field_title(name: str) -> tuple[str, str]:
    """A swept field in words, such as `cell` or `camera exposure grey`, and its unit, empty where it has none."""
    end = next((end for end in UNITS if name.endswith(end)), "")
    return name.removesuffix(end).partition(".")[2].replace(".", " ").replace("_", " "), UNITS.get(end, "")
