"""Whatever an evaluation prints or stores has a row in the table of measures, which its report and the pages show."""

import csv
import html
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.page import COLUMNS, junit, render_page
from magicsim.judge.measures import COMPUTE, FILE, TABLE

ROOT = Path(__file__).parents[3]

BESIDE = {"episodes", "frames", "verdicts", "seconds", "confusion", "low", "high", "above_mm", "to_mm"}
"""Numbers of a JSON that say how much was judged, of which bin, and the ends of intervals."""


def numbers(content: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The path of every number in a JSON, places in lists left out."""
    if isinstance(content, dict):
        for name, each in content.items():
            yield from numbers(each, (*path, name))
    elif isinstance(content, list):
        for each in content:
            yield from numbers(each, path)
    elif isinstance(content, int | float) and not isinstance(content, bool):
        yield path


def without_row(content: dict[str, object]) -> set[str]:
    compared = content.pop("compared") + content.pop("regressions") + content.pop("improvements")
    content.pop("provenance")
    rest = {".".join(path) for path in numbers(content) if not {*TABLE, *BESIDE} & set(path)}
    return rest | {each["measure"] for each in compared if each["measure"] not in TABLE}


def test_every_number_of_the_json_has_a_row(worse: Evaluation):
    assert worse.as_dict()["compared"]
    assert without_row(worse.as_dict()) == set()
    rest = [each | {"touch": each["touch"] | {"skew": 0.1}} for each in worse.as_dict()["rest"]]
    assert without_row(worse.as_dict() | {"rest": rest, "odd": 1}) == {"rest.touch.skew", "odd"}


def test_every_row_says_what_it_means_and_whether_its_falls_are_tested(worse: Evaluation):
    assert set(COMPUTE) <= set(TABLE)
    with FILE.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    assert {len(line) for line in lines} == {9}
    assert [line[0] for line in lines[1:]] == list(TABLE)
    for name, kind in TABLE.items():
        assert kind.title, name
        assert re.fullmatch(r"[A-Z].+\.", kind.meaning), name
        assert kind.better in {"higher", "lower", None}, name
        assert kind.task in {"proximity", "contact", ""}, name
    assert {each.measure for each in worse.changes} <= {name for name, each in TABLE.items() if each.matters}
    assert {each.matters for each in worse.changes if each.measure == "lead_mm"} <= {0.5}


def test_report_and_junit_say_what_each_measure_means_and_what_fall_could_be_found(worse: Evaluation):
    text = html.unescape(render_page(worse))
    for kind in TABLE.values():
        assert kind.title in text
        assert kind.meaning in text
    assert all(column in text for column in COLUMNS.values())
    cases = junit(worse).getroot().findall("testcase")
    told = {case.get("name"): properties(case) for case in cases if case.find("properties") is not None}
    assert {TABLE[each.measure].title for each in worse.changes} == set(told)
    for each in worse.changes:
        assert told[TABLE[each.measure].title].keys() == {"meaning", "smallest fall to be found"}


def properties(case: ElementTree.Element) -> dict[str | None, str | None]:
    return {each.get("name"): each.get("value") for each in case.iter("property")}


def test_documentation_shows_the_same_table():
    page = (ROOT / "docs" / "commands" / "judge.md").read_text("utf-8")
    shown = re.search(r"^```\{csv-table\}.*\n:file: (.+)\n:header-rows: 1\n", page, re.MULTILINE)
    assert shown is not None
    assert (ROOT / "docs" / "commands" / shown[1]).resolve() == FILE.resolve()
