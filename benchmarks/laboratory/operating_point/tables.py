"""The result of a search as Markdown tables, drawn from its JSON alone."""

from collections.abc import Mapping, Sequence
from typing import Any

from laboratory.markdown import markdown_table
from laboratory.operating_point.filming import GAPS_MM, TOUCHES_MM

DASH = "-"
THOUSAND = 1000
FRONT_ROWS = 6
"""Rows of the front that are shown."""


def tables(summary: Mapping[str, Any]) -> str:
    """All tables of the page.

    Args:
        summary: What `laboratory.operating_point.ensemble.summarise` returned, with `check` where there is one.
    """
    check = summary.get("check", {})
    parts = [
        f"*{summary['steps']} choices of optical constants, {summary['candidates']} cameras with a grid to read, "
        f"{summary['cpu_seconds'] / 60:.0f} CPU minutes; {len(summary['ensemble'])} members, distance "
        f"{summary['distance']['best']:.2f} to {summary['distance']['worst_member']:.2f} tolerances.*",
        _quantities(summary, check),
        _constants(summary),
        _colours(summary, check),
        _counts(summary),
        _front(summary),
        _exclusive(summary),
    ]
    if check.get("verdicts"):
        parts.append(_verdicts(check["verdicts"]))
    if check.get("without"):
        parts.append(_without(check["without"]))
    if check.get("members"):
        parts.append(_members(check["members"]))
    return "\n\n".join(parts) + "\n"


def _quantities(summary: Mapping[str, Any], check: Mapping[str, Any]) -> str:
    rows = []
    for name, target in summary["targets"].items():
        found = summary["quantities"][name]
        defaults = [
            _number(check.get(key, {}).get("quantities", {}).get(name)) for key in ("default", "default_careful")
        ]
        rows.append(
            [
                f"{target['says']}{' [' + target['unit'] + ']' if target['unit'] else ''}",
                _interval(target["low"], target["high"]),
                *defaults,
                f"{found['low']:.2f} to {found['high']:.2f}",
                f"{found['distance_median']:+.1f}",
                f"{round(summary['candidates'] * found['reached_alone'])} of {summary['candidates']}",
            ]
        )
    head = [
        "published",
        "target",
        "default",
        "default, less noise",
        "ensemble",
        "left [tolerances]",
        "met alone by",
    ]
    return markdown_table(head, rows)


def _constants(summary: Mapping[str, Any]) -> str:
    rows = [
        [
            f"`{name}`",
            f"{found['low']:.2f}",
            f"{found['median']:.2f}",
            f"{found['high']:.2f}",
            f"{found['spread']:.2f}",
            _values(found["values"]),
        ]
        for name, found in summary["constants"].items()
    ]
    head = ["constant, share of its range", "low", "median", "high", "spread (1 = even)", "value"]
    return markdown_table(head, rows)


def _counts(summary: Mapping[str, Any]) -> str:
    found, total = summary["counts"], summary["candidates"]
    settled = ", ".join(f"{_number(best)} after {steps}" for steps, best in found["settled"].items())
    rows = [
        ["best distance, by steps", settled],
        *(
            [f"mean C near an object, {part} third of the crosstalk", _number(value)]
            for part, value in found["crosstalk"].items()
        ),
    ]
    rows += [
        [f"best contact by the published thresholds{which}, balanced", _number(found["contact"][key])]
        for key, which in (("best", ""), ("with_proximity", ", rest, near and flashlight told as well"))
    ]
    if found["as_near"] is not None:
        rows.append(["at least as near as the default in every quantity", _as_near(found["as_near"], total)])
    return markdown_table(["of all sensors", "found"], rows)


def _as_near(found: Sequence[float], total: int) -> str:
    apart = f", at distances of {found[0]:.2f} to {found[-1]:.2f}" if found else ""
    return f"{len(found)} of {total}{apart}"


def _values(values: Sequence[float | str]) -> str:
    numbers = [each for each in values if not isinstance(each, str)]
    if len(numbers) < len(values):
        return ", ".join(sorted({str(each) for each in values}))
    ends = (min(numbers), max(numbers))
    return " to ".join(f"{each:.0f}" if each >= THOUSAND else f"{each:.3g}" for each in ends)


def _colours(summary: Mapping[str, Any], check: Mapping[str, Any]) -> str:
    readings = {"best of the search": summary["best"]["reading"]}
    readings |= {
        title: check[key]
        for key, title in (("default", "default"), ("default_careful", "default, less noise"))
        if key in check
    }
    rows = [
        [
            title,
            *(f"{each:.2f}" for each in found["evenness"]),
            *(f"{found['disparity'][key]:.2f}" for key in ("rest", "touch", "light")),
        ]
        for title, found in readings.items()
    ]
    head = ["sensor", "evenness red", "green", "blue", "disparity at rest", "in contact", "under light"]
    return markdown_table(head, rows)


def _members(members: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [
            str(number),
            f"{each['searched']['distance']:.2f}",
            DASH if each["careful"] is None else f"{each['careful']['distance']:.2f}",
        ]
        for number, each in enumerate(members, 1)
    ]
    return markdown_table(["member", "distance", "distance, less noise"], rows)


def _verdicts(sensor: Mapping[str, Any]) -> str:
    """E, C and S of one sensor at every state, as in the search and with less noise."""
    states = [*(f"{gap:g} mm away" for gap in GAPS_MM), *(f"{depth:g} mm deep" for depth in TOUCHES_MM)]
    readings = [sensor["searched"]["reading"], *([sensor["careful"]["reading"]] if sensor["careful"] else [])]
    rows = [
        [
            state,
            *(
                f"{reading[name][place]:.2f}"
                for reading in readings
                for name in ("entropy", "correlation", "similarity")
            ),
        ]
        for place, state in enumerate(states)
    ]
    for state, key in (("untouched", "rest"), ("flashlight", "light")):
        row = [state]
        for reading in readings:
            row += [
                DASH if value is None else f"{value:.2f}"
                for value in (reading["quantities"].get(f"{letter}_{key}") for letter in "ecs")
            ]
        rows.append(row)
    head = [f"{letter}{noise}" for noise in ("", ", less noise")[: len(readings)] for letter in ("E [bit]", "C", "S")]
    return markdown_table(["the sensor nearest to right verdicts", *head], rows)


def _front(summary: Mapping[str, Any]) -> str:
    """The widest sets of targets that are met together, as what each leaves out."""
    says = {name: each["says"] for name, each in summary["targets"].items()}
    rows = [
        [
            str(len(each["met"])),
            str(each["sensors"]),
            "; ".join(words for name, words in says.items() if name not in each["met"]),
        ]
        for each in summary["front"][:FRONT_ROWS]
    ]
    return markdown_table(["targets met together", "sensors", "not met"], rows)


def _exclusive(summary: Mapping[str, Any]) -> str:
    says = {name: each["says"] for name, each in summary["targets"].items()}
    rows = [[says[one], says[other]] for one, other in summary["exclusive"]]
    return markdown_table(["no sensor meets both", "and"], rows or [[DASH, DASH]])


def _without(without: Mapping[str, float | None]) -> str:
    rows = [[name, "no grid to read" if value is None else f"{value:.2f}"] for name, value in without.items()]
    return markdown_table(["the sensor that meets most, without", "distance"], rows)


def _number(value: float | None) -> str:
    return DASH if value is None else f"{value:.2f}"


def _interval(low: float | None, high: float | None) -> str:
    if low is None:
        return f"up to {high:g}"
    return f"from {low:g}" if high is None else f"{low:g} to {high:g}"
