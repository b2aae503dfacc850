"""Names, docstrings and paths."""

import ast
import re
from pathlib import Path

from .source import EXPERIMENTS, ROOT, modules

VAGUE = {"utils", "util", "helpers", "helper", "common", "manager", "misc", "tools", "core", "base"}
FOLDERS = ("magicsim", "geometry", "scenes", "detectors", "tests", "benchmarks", "docs")
OPENINGS = ("The same", "Of ", "That of", "Those of", "As ", "Its ")
"""How a docstring begins that leaves out what it is about."""
TEXT = {".py", ".toml", ".md", ".jinja", ".html", ".css", ".yml", ".yaml", ".txt", ".json"}
# A folder of one machine, at the start of a path.
ABSOLUTE = re.compile(r"(?<![\w.~/})])/(?:home|root|tmp|work|Users|mnt|opt|srv|var)/\w")


def sources() -> list[Path]:
    files = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in TEXT]
    files += [path for path in ROOT.iterdir() if path.suffix in TEXT]
    return [path for path in files if path.is_file() and "__pycache__" not in path.parts]


def test_modules_are_named_after_concepts():
    assert not [module for module in modules() if set(module.split(".")) & VAGUE]
    assert not [module for module in modules() if not re.fullmatch(r"[a-z0-9_.]+", module)]


def test_docstrings_name_their_subject():
    texts = [
        f"{module}:{node.lineno}: {node.value.value[:60]}"
        for module, tree in (modules() | modules(EXPERIMENTS)).items()
        for node in ast.walk(tree)
        if _is_text(node) and node.value.value.startswith(OPENINGS)
    ]
    assert not texts


def _is_text(node: ast.AST) -> bool:
    """Whether a statement is a text alone."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def test_no_source_holds_an_absolute_path_of_one_machine():
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in sources()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if ABSOLUTE.search(line)
    ]
    assert not found


def test_search_for_absolute_paths_tells_them_from_relative_ones():
    assert all(ABSOLUTE.search(line) for line in ('open("/' + 'tmp/frames")', "cd /" + "home/me"))
    others = ("see docs/work/plan", "https://example.org/" + "home/page", "~/work/x")
    assert not any(ABSOLUTE.search(line) for line in others)
