"""The notebooks' cells are Python that imports what exists; the documentation's build runs them."""

import ast
import importlib
import re
from pathlib import Path

import pytest

from .pages import DOCS, name

NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.md"))
CELL = re.compile(r"^```\{code-cell\} ipython3\n(?P<code>.*?)^```", re.MULTILINE | re.DOTALL)


def cells(page: Path) -> list[str]:
    return [match["code"] for match in CELL.finditer(page.read_text(encoding="utf-8"))]


def test_there_are_notebooks():
    assert [page.stem for page in NOTEBOOKS] == ["first-frame", "own-design", "own-detector", "train"]


@pytest.mark.parametrize("page", NOTEBOOKS, ids=name)
def test_cells_parse_and_import_what_exists(page: Path):
    assert len(cells(page)) > 2
    for node in [each for code in cells(page) for each in ast.walk(ast.parse(code))]:
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            module = importlib.import_module(node.module)
            assert all(hasattr(module, alias.name) for alias in node.names)
