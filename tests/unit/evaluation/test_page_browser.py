"""The evaluation's page in a real browser: complete, readable at any width, reached by keyboard."""

from pathlib import Path

import pytest

from magicsim.evaluation.evaluate import Evaluation
from magicsim.evaluation.page import render_page

pytestmark = pytest.mark.browser


@pytest.fixture
def opened(page, found: Evaluation, tmp_path: Path):
    file = tmp_path / "evaluation.html"
    file.write_text(render_page(found), encoding="utf-8")
    page.goto(file.as_uri())
    return page


def test_page_shows_every_group_and_fits_its_window(opened, found: Evaluation):
    text = opened.locator("body").inner_text()
    assert all(group in text for group in found.metrics)
    assert opened.evaluate("[...document.images].every(each => each.complete && each.naturalWidth > 0)")
    assert opened.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_keyboard_alone_opens_everything(opened):
    closed = opened.locator("details:not([open]) > summary")
    for _ in range(closed.count()):
        closed.first.focus()
        opened.keyboard.press("Enter")
    assert closed.count() == 0
    opened.keyboard.press("End")
    end = "() => window.scrollY + window.innerHeight >= document.documentElement.scrollHeight - 2"
    opened.wait_for_function(end)
