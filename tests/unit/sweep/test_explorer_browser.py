"""The explorer in a real browser: clicks, comparison, download, and no error on its console."""

import csv
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from magicsim.sweep.explorer.page import render_explorer
from magicsim.sweep.explorer.trends import check_trends
from magicsim.sweep.result import DesignResult

from .fakes import NOTE, small_sweep

pytestmark = pytest.mark.slow
playwright = pytest.importorskip("playwright.sync_api")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZES = {"desktop": (1280, 900), "phone": (390, 844)}


@pytest.fixture(scope="module")
def browser() -> Iterator[object]:
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no Chromium on this machine")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture(params=SIZES)
def page(request, browser, results: list[DesignResult], tmp_path: Path) -> Iterator[object]:
    file = tmp_path / "report.html"
    front = [number in {0, 2} for number in range(len(results))]
    trends = check_trends(results)
    file.write_text(render_explorer(small_sweep(), results, front=front, trends=trends, failed={}), encoding="utf-8")
    width, height = SIZES[request.param]
    opened = browser.new_page(viewport={"width": width, "height": height})
    complaints: list[str] = []
    opened.on("console", lambda said: complaints.append(said.text) if said.type in {"error", "warning"} else None)
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on(
        "request",
        lambda asked: None if asked.url.startswith(("file:", "data:", "blob:")) else complaints.append(asked.url),
    )
    opened.goto(file.as_uri())
    yield opened
    assert complaints == []
    opened.close()


def test_map_shows_every_design_and_a_click_chooses_one(page):
    assert page.locator("#map .grid .cell[data-design]").count() == 4
    assert page.locator("#map .others .cell").count() == 1
    page.locator("#map .cell[data-design='3']").click()
    assert "A: cell 1.2" in page.locator("#sections").inner_text()
    assert page.locator("#sections svg rect").count() > 10
    assert page.locator("#frames img").count() == 2
    assert page.locator("#curves .card").count() >= 5


def test_other_measure_changes_the_map(page):
    before = page.locator("#map .cell[data-design='0']").inner_text()
    page.select_option("#measure", "shore_a")
    after = page.locator("#map .cell[data-design='0']").inner_text()
    assert before != after
    assert after.startswith("27.0")
    assert "Shore A" in page.locator("#scale").inner_text()


def test_two_designs_are_compared_and_one_is_dropped_again(page):
    page.locator("#map .cell[data-design='0']").click()
    page.click("#slot-b")
    page.locator("#map .cell[data-design='3']").click()
    assert page.locator("#numbers thead th").all_inner_texts() == ["measure", "A", "B"]
    assert page.locator("#frames img").count() == 4
    assert page.locator("#sections svg").count() == 2
    page.click("#drop-b")
    assert page.locator("#numbers thead th").all_inner_texts() == ["measure", "A"]


def test_axes_can_be_swapped_and_the_trade_off_chosen(page):
    page.select_option("#across", "design.skin_mm")
    assert page.input_value("#down") == "design.cell_mm"
    assert page.locator("#map .grid .cell[data-design]").count() == 4
    page.select_option("#trade-x", "shore_a")
    page.locator("#trade .point").last.click()
    assert page.locator("#map .cell.a").count() == 1


def test_table_sorts_and_downloads_as_csv(page, tmp_path: Path):
    page.locator("#table th button", has_text="Shore A").click()
    page.locator("#table th button", has_text="Shore A").click()
    first = page.locator("#table tbody tr").first.inner_text()
    assert first.split()[0] in {"1", "3"}
    with page.expect_download() as download:
        page.click("#download")
    target = tmp_path / "sweep.csv"
    download.value.save_as(target)
    rows = list(csv.DictReader(target.read_text(encoding="utf-8").splitlines()))
    assert [row["design"] for row in rows] == ["0", "1", "2", "3", "4"]
    assert {row["printability_note"] for row in rows} == {NOTE}


def test_marks_of_a_curve_stand_inside_its_drawing(page):
    marks = page.locator("#curves line[style*=dasharray]")
    assert marks.count() == 2  # half of the frames are told, d' = 2
    assert all(float(mark.get_attribute("y1")) > 0 for mark in marks.all())


def test_page_is_no_wider_than_its_window(page):
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
