"""The explorer: all results of a sweep on one page that needs no network, no server and no other file."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from markupsafe import Markup

from magicsim.errors import visible
from magicsim.report.templates import page_template
from magicsim.sweep.explorer.trends import TrendCheck
from magicsim.sweep.judging.measures import described
from magicsim.sweep.result import DesignResult, finite
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.sweep.table import rows_of, table_csv

UNITS = {"_per_mm": "1/mm", "_mm": "mm", "_mpa": "MPa", "_deg": "°", "_px": "px"}
"""Units by the end of a field's name, the longer end first."""


def render_explorer(
    sweep: SweepConfig,
    results: Sequence[DesignResult],
    *,
    front: Sequence[bool],
    trends: Sequence[TrendCheck],
    failed: Mapping[str, str],
) -> str:
    """The page.

    Args:
        sweep: What was asked for.
        results: All judged designs.
        front: Whether each is in the Pareto front.
        trends: Checked trends.
        failed: Why a design has no result, by its number.
    """
    title = f"Design sweep: {len(results)} designs"
    return page_template("explorer.html.jinja", "magicsim.sweep.explorer").render(
        title=title,
        subtitle=" by ".join(f"{field_label(each.field)} ({field_unit(each.field)})" for each in sweep.swept),
        data=Markup(script_json(explorer_data(sweep, results, front=front))),
        trends=trends,
        failed=failed,
        measures=described(sweep.quality),
        signed=signed,
        has_results=bool(results),
    )


def explorer_data(sweep: SweepConfig, results: Sequence[DesignResult], *, front: Sequence[bool]) -> dict[str, Any]:
    """What the page's script works on."""
    kinds = described(sweep.quality)
    fields = sorted({name for result in results for name in result.values})
    swept = [each.field for each in sweep.swept]
    order = [*swept, *(name for name in fields if name not in swept)]
    measured = [name for name in sweep.measures if any(name in result.measures for result in results)]
    return {
        "fields": [{"name": name, "label": field_label(name), "unit": field_unit(name)} for name in order],
        "measures": [{"name": name} | asdict(kinds[name]) for name in measured],
        "objectives": [{"measure": each.measure, "better": each.way} for each in sweep.objectives],
        "designs": [
            _shown(finite(asdict(result))) | {"front": bool(in_front)}
            for result, in_front in zip(results, front, strict=True)
        ],
        "csv": table_csv(rows_of(results, front)).decode(),
    }  # fmt: skip


def script_json(value: object) -> str:
    """JSON that may stand inside a script element, whatever text it holds."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _shown(value: Any) -> Any:  # noqa: ANN401 - any nesting that JSON has
    """The value with what hides in its texts spelt out."""
    if isinstance(value, Mapping):
        return {key: _shown(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_shown(each) for each in value]
    return visible(value) if isinstance(value, str) else value


def signed(value: float, digits: int) -> str:
    """A change with its sign, such as `+1.20`."""
    return f"{value:+.{digits}f}".replace("-", "\u2212")


def field_label(name: str) -> str:
    """A swept field in words, such as `cell` or `camera exposure grey`."""
    return name.removesuffix(_end(name)).partition(".")[2].replace(".", " ").replace("_", " ")


def field_unit(name: str) -> str:
    """Its unit, empty where it has none."""
    return UNITS.get(_end(name), "")


def _end(name: str) -> str:
    return next((end for end in UNITS if name.endswith(end)), "")
