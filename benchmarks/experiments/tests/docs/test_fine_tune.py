"""The notebook that makes a model one of another unit: its cells import what exists, and end with a better one."""

import ast
import importlib
import re

import pytest

from .pages import DOCS

pytest.importorskip("torch")

CELL = re.compile(r"^```\{code-cell\} ipython3\n(?P<code>.*?)^```", re.MULTILINE | re.DOTALL)
CELLS = [match["code"] for match in CELL.finditer((DOCS / "notebooks" / "fine-tune.md").read_text(encoding="utf-8"))]


def test_cells_import_what_exists():
    assert len(CELLS) == 4
    for node in [each for code in CELLS for each in ast.walk(ast.parse(code))]:
        if isinstance(node, ast.ImportFrom) and node.module is not None and "magicsim" in node.module:
            module = importlib.import_module(node.module)
            assert all(hasattr(module, alias.name) for alias in node.names)


@pytest.mark.slow
def test_a_hundred_frames_make_it_a_better_model_of_their_unit():
    found: dict[str, object] = {}
    for code in CELLS:
        exec(code, found)
    before, after = found["errors"]
    names = [label.name for label in found["config"].labels]
    assert all(after[names.index(name)] < before[names.index(name)] for name in ("p_x", "p_y", "f_z"))
