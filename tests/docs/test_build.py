"""The documentation builds without a warning, and its pages need nothing from outside."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from .pages import DOCS

pytestmark = pytest.mark.slow
OUTSIDE = re.compile(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(https?:)?//')


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for package in ("sphinx", "furo", "myst_nb"):
        pytest.importorskip(package)
    out = tmp_path_factory.mktemp("html")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", str(DOCS), str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def test_every_page_is_built(built: Path):
    pages = {page.relative_to(DOCS).with_suffix(".html") for page in DOCS.rglob("*.md")}
    assert {page for page in pages if not (built / page).is_file()} == set()


def test_pages_load_nothing_from_outside(built: Path):
    assert [page.name for page in built.rglob("*.html") if OUTSIDE.search(page.read_text(encoding="utf-8"))] == []


def test_formulas_are_drawn_by_the_browser(built: Path):
    assert "<math" in (built / "physics" / "mechanics.html").read_text(encoding="utf-8")
