"""The explorer in a real browser: clicks, comparison, download, and no error on its console."""

import csv
from pathlib import Path

import pytest

from magicsim.sweep.explorer import render_explorer
from magicsim.sweep.result import DesignResult
from magicsim.sweep.verdicts import check_trends

from .fakes import NOTE, small_sweep

pytestmark = pytest.mark.browser


@pytest.fixture
def explorer(page, results: list[DesignResult], tmp_path: Path):
    file = tmp_path / "report.html"
    front = [number in {0, 2} for number in range(len(results))]
    trends = check_trends(results)
    file.write_text(
        render_explorer(small_sweep(), results, front=front, trends=trends, failed={}, verdicts={}), encoding="utf-8"
    )
    page.goto(file.as_uri())
    return page


def test_map_shows_every_design_and_a_click_chooses_one(explorer):
    assert explorer.locator("#map .grid .cell[data-design]").count() == 4
    assert explorer.locator("#map .others .cell").count() == 1
    explorer.locator("#map .cell[data-design='3']").click()
    assert "A: cell 1.2" in explorer.locator("#sections").inner_text()
    assert explorer.locator("#sections svg rect").count() > 10
    assert explorer.locator("#frames img").count() == 2
    assert explorer.locator("#curves .card").count() >= 5


def test_other_measure_changes_the_map(explorer):
    before = explorer.locator("#map .cell[data-design='0']").inner_text()
    explorer.select_option("#measure", "shore_a")
    after = explorer.locator("#map .cell[data-design='0']").inner_text()
    assert before != after
    assert after.startswith("27.0")
    assert "Shore A" in explorer.locator("#scale").inner_text()


def test_two_designs_are_compared_and_one_is_dropped_again(explorer):
    explorer.locator("#map .cell[data-design='0']").click()
    explorer.click("#slot-b")
    explorer.locator("#map .cell[data-design='3']").click()
    assert explorer.locator("#numbers thead th").all_inner_texts() == ["measure", "A", "B"]
    assert explorer.locator("#frames img").count() == 4
    assert explorer.locator("#sections svg").count() == 2
    explorer.click("#drop-b")
    assert explorer.locator("#numbers thead th").all_inner_texts() == ["measure", "A"]


def test_axes_can_be_swapped_and_the_trade_off_chosen(explorer):
    explorer.select_option("#across", "design.skin_mm")
    assert explorer.input_value("#down") == "design.cell_mm"
    assert explorer.locator("#map .grid .cell[data-design]").count() == 4
    explorer.select_option("#trade-x", "shore_a")
    explorer.locator("#trade .point").last.click()
    assert explorer.locator("#map .cell.a").count() == 1


def test_table_sorts_and_downloads_as_csv(explorer, tmp_path: Path):
    explorer.locator("#table th button", has_text="Shore A").click()
    explorer.locator("#table th button", has_text="Shore A").click()
    first = explorer.locator("#table tbody tr").first.inner_text()
    assert first.split()[0] in {"1", "3"}
    with explorer.expect_download() as download:
        explorer.click("#download")
    target = tmp_path / "sweep.csv"
    download.value.save_as(target)
    rows = list(csv.DictReader(target.read_text(encoding="utf-8").splitlines()))
    assert [row["design"] for row in rows] == ["0", "1", "2", "3", "4"]
    assert {row["printability_note"] for row in rows} == {NOTE}


def test_marks_of_a_curve_stand_inside_its_drawing(explorer):
    marks = explorer.locator("#curves line[style*=dasharray]")
    assert marks.count() == 2  # half of the frames are told, d' = 2
    assert all(float(mark.get_attribute("y1")) > 0 for mark in marks.all())


def test_page_is_no_wider_than_its_window(explorer):
    assert explorer.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_keyboard_alone_chooses_designs_sorts_and_reaches_the_download(explorer, tabbed):
    reached = tabbed(explorer)
    assert any("Shore A" in name for _, name in reached)
    explorer.locator("#map .cell[data-design='3']").focus()
    explorer.keyboard.press("Enter")
    assert "A: cell 1.2" in explorer.locator("#sections").inner_text()
    explorer.locator("#table th button", has_text="Shore A").focus()
    explorer.keyboard.press("Enter")
    explorer.keyboard.press("Enter")
    assert explorer.locator("#table tbody tr").first.inner_text().split()[0] in {"1", "3"}
    explorer.locator("#download").focus()
    with explorer.expect_download():
        explorer.keyboard.press("Enter")
