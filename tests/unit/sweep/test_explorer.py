import csv
import io
import json
import re
from dataclasses import replace

import pytest

from magicsim.errors import visible
from magicsim.sweep.explorer import (
    explorer_data,
    field_title,
    render_explorer,
    rows_of,
    script_json,
    table_csv,
)
from magicsim.sweep.measures import described
from magicsim.sweep.result import DesignResult
from magicsim.sweep.verdicts import check_trends
from sweep.fakes import NOTE, small_sweep


@pytest.fixture
def page(results: list[DesignResult]) -> str:
    front = [True] * len(results)
    return render_explorer(
        small_sweep(),
        results,
        front=front,
        trends=check_trends(results),
        failed={"9": "no <cell> fits"},
        verdicts={"shore_a": "indistinguishable"},
    )


def test_page_loads_nothing_from_outside(page: str):
    assert not re.findall(r"(?:src|href)=\"(?!data:)", page)
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert "no &lt;cell&gt; fits" in page


def test_data_in_the_page_is_that_of_the_results(page: str, results: list[DesignResult]):
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    data = json.loads(text)
    assert [each["index"] for each in data["designs"]] == [0, 1, 2, 3, 4]
    assert data["designs"][1]["measures"]["shore_a"]["value"] == results[1].measures["shore_a"].value
    assert {each["name"]: each["verdict"] for each in data["measures"]}["shore_a"] == "indistinguishable"
    assert [each["name"] for each in data["fields"]] == ["design.cell_mm", "design.skin_mm", "design.core_mm"]
    rows = list(csv.DictReader(data["csv"].splitlines()))
    assert [row["printability_note"] for row in rows] == [NOTE] * 5


def test_meanings_name_what_the_quality_says(results: list[DesignResult]):
    sweep = small_sweep("quality.light_depth_mm=0.2", "quality.touch_depth_mm=0.45", "quality.drift=0.05")
    page = render_explorer(sweep, results, front=[True] * 5, trends=[], failed={}, verdicts={})
    assert "from 0.2 to 0.45 mm, mean over places" in page
    assert "lights 5 % stronger" in page
    assert "{" not in "".join(kind.meaning for kind in described(sweep.quality).values())


def test_title_names_units_where_there_are_any():
    swept = "swept=[{field='design.skin_mm',values=[1.0]},{field='rig.room',values=['dark']}]"
    sweep = small_sweep("rig=digit-office", swept)
    page = render_explorer(sweep, [], front=[], trends=[], failed={}, verdicts={})
    assert "skin (mm) by room</p>" in page


def test_every_curve_that_a_film_has_is_drawn(results: list[DesignResult]):
    page = render_explorer(small_sweep(), results, front=[True] * 5, trends=[], failed={}, verdicts={})
    for name in ("force", "similarity", "approach", "contact", "localisation"):
        assert f'curve: "{name}"' in page or f"curves.{name}" in page


def test_text_cannot_leave_its_script_element():
    assert "</script" not in script_json({"note": "</script><b>&"})
    assert json.loads(script_json({"note": "</script><b>&"})) == {"note": "</script><b>&"}


def test_page_of_no_result_says_so():
    page = render_explorer(small_sweep(), [], front=[], trends=[], failed={"0": "no cell fits"}, verdicts={})
    assert "No design has a result" in page


@pytest.mark.parametrize(
    ("name", "label", "unit"),
    [
        ("design.cell_mm", "cell", "mm"),
        ("design.materials.infill.sigma_s_per_mm", "materials infill sigma s", "1/mm"),
        ("rig.camera.gamma", "camera gamma", ""),
        ("rig.strips.1.margin_mm", "strips 1 margin", "mm"),
    ],
)
def test_fields_are_named_in_words_with_their_unit(name: str, label: str, unit: str):
    assert field_title(name) == (label, unit)


def test_result_survives_its_json(results: list[DesignResult]):
    once = DesignResult.from_json(results[0].to_json())  # eight digits are kept
    assert once.measures["shore_a"].value == results[0].measures["shore_a"].value
    assert DesignResult.from_json(once.to_json()) == once


def test_explorer_keeps_measures_that_some_design_has(results: list[DesignResult]):
    sweep = small_sweep("measures=['shore_a','unknowns']", "objectives=[{measure='unknowns'}]")
    data = explorer_data(sweep, results, front=[False] * 5, verdicts={})
    assert [each["name"] for each in data["measures"]] == ["shore_a", "unknowns"]


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)", "<!--<script>", "{{ 7 * 6 }}", "a\u202eb\x1b", "'\"&", "\u2028\u2029"]
)
def test_hostile_notes_captions_and_failures_stay_text(results: list[DesignResult], name: str):
    first = results[0]
    measures = {key: replace(each, note=name) for key, each in first.measures.items()}
    changed = [replace(first, measures=measures, pictures={name: "data:,"}), *results[1:]]
    page = render_explorer(small_sweep(), changed, front=[True] * 5, trends=[], failed={"9": name}, verdicts={})
    assert page.count("<script") == 2
    assert page.count("</script") == 2
    assert not {"\u202e", "\x1b", "\u2028"} & set(page)
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    (note,) = {each["note"] for each in json.loads(text)["designs"][0]["measures"].values()}
    assert note == visible(name)


@pytest.mark.parametrize("begin", ["=", "+", "-", "@", "\t", "\r"])
def test_text_cells_that_begin_as_a_formula_stay_text(results: list[DesignResult], begin: str):
    note = begin + 'HYPERLINK("x")'
    measures = {key: replace(each, note=note, value=-0.5) for key, each in results[0].measures.items()}
    rows = rows_of([replace(results[0], measures=measures)], [True])
    (row,) = csv.DictReader(io.StringIO(table_csv(rows).decode(), newline=""))
    assert row["printability_note"] == "'" + note
    assert row["printability"] == "-0.5"
    assert not any(cell.startswith(begin) and not re.fullmatch(r"[-+]?[\d.e-]+", cell) for cell in row.values())
