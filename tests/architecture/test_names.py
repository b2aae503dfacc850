"""Names, docstrings and paths."""

import ast
import re
from pathlib import Path

import pytest

from .source import PACKAGE, ROOT, modules

VAGUE = {"utils", "util", "helpers", "helper", "common", "manager", "misc", "tools", "core", "base"}
FOLDERS = ("magicsim", "geometry", "scenes", "detectors", "tests", "benchmarks", "docs")
TEXT = {".py", ".toml", ".md", ".jinja", ".html", ".css", ".yml", ".yaml", ".txt", ".json"}
# A folder of one machine, at the start of a path.
ABSOLUTE = re.compile(r"(?<![\w.~/})])/(?:home|root|tmp|work|Users|mnt|opt|srv|var)/\w")


def sources() -> list[Path]:
    files = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in TEXT]
    files += [path for path in ROOT.iterdir() if path.suffix in TEXT]
    return [path for path in files if path.is_file() and "__pycache__" not in path.parts]


@pytest.mark.parametrize("module", modules())
def test_module_is_named_after_a_concept(module: str):
    assert not set(module.split(".")) & VAGUE
    assert re.fullmatch(r"[a-z0-9_.]+", module)


@pytest.mark.parametrize("module", modules())
def test_module_and_its_public_classes_and_functions_say_what_they_are(module: str):
    tree = modules()[module]
    assert ast.get_docstring(tree), module
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.ClassDef | ast.FunctionDef)
            and not node.name.startswith("_")
            and _is_public(tree, node)
        ):
            assert ast.get_docstring(node), f"{module}.{node.name}"


@pytest.mark.parametrize("module", modules())
def test_docstrings_name_their_subject(module: str):
    strings = [node.value.value for node in ast.walk(modules()[module]) if _is_text(node)]
    assert not [text for text in strings if text.startswith(("The same", "Of "))]


def _is_text(node: ast.AST) -> bool:
    """Whether a statement is a text alone."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _is_public(tree: ast.Module, node: ast.ClassDef | ast.FunctionDef) -> bool:
    """Whether a definition stands at the top level or in a public class, not inside a function."""
    homes = [tree, *(each for each in tree.body if isinstance(each, ast.ClassDef) and not each.name.startswith("_"))]
    return any(node in home.body for home in homes)


def test_no_source_holds_an_absolute_path_of_one_machine():
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in sources()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if ABSOLUTE.search(line)
    ]
    assert not found


@pytest.mark.parametrize(
    ("line", "is_found"),
    [
        ('open("/' + 'tmp/frames")', True),
        ("cd /" + "home/me", True),
        ("see docs/work/plan", False),
        ("https://example.org/" + "home/page", False),
        ("~/work/x", False),
    ],
)
def test_search_for_absolute_paths_tells_them_from_relative_ones(line: str, is_found: bool):
    assert bool(ABSOLUTE.search(line)) == is_found


def test_imports_do_not_edit_the_search_path():
    for path in PACKAGE.rglob("*.py"):
        assert "sys.path" not in path.read_text(encoding="utf-8"), path.name
