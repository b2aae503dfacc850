"""The report in a real browser: complete, readable at any width, reached by keyboard."""

from pathlib import Path

import pytest

from magicsim.notebook.screen import EDGE_PX
from magicsim.report.episode_report import animate
from magicsim.report.page import render_report

from .synthetic import make_episode, make_judgement

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, episode = tmp_path_factory.mktemp("report"), make_episode()
    judgements = [make_judgement(episode, tau_e=1.9), make_judgement(episode, "published", tau_e=0.5, tau_g=0.6)]
    (folder / "report.html").write_text(render_report(episode, judgements, {"Estimator": "fluence"}), encoding="utf-8")
    animate(episode, folder / "preview.webp", verdicts=judgements[0].verdicts)
    return folder


def test_report_shows_every_picture_and_fits_its_window(page, folder: Path):
    page.goto((folder / "report.html").as_uri())
    pictures = page.locator("img")
    assert pictures.count() > 3
    assert page.evaluate("[...document.images].every(each => each.complete && each.naturalWidth > 0)")
    assert page.evaluate("[...document.images].every(each => each.alt !== '')")
    widths = page.evaluate("[...document.images].map(each => each.naturalWidth)")
    assert set(widths) == {2 * 24 + EDGE_PX}
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_keyboard_alone_reaches_and_opens_what_can_be_opened(page, tabbed, folder: Path):
    page.goto((folder / "report.html").as_uri())
    closed = page.locator("details:not([open]) > summary")
    count = closed.count()
    reached = tabbed(page)
    assert len([tag for tag, _ in reached if tag == "summary"]) >= min(count, 1)
    for _ in range(count):
        closed.first.focus()
        page.keyboard.press("Enter")
    assert closed.count() == 0


def test_preview_plays(page, folder: Path):
    page.goto((folder / "preview.webp").as_uri())
    assert page.evaluate("document.images[0].decode().then(() => document.images[0].naturalWidth > 0)")
