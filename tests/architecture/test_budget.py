"""No part grows above its budget: lines and files of Python, words of documentation."""

import tomllib
from pathlib import Path

from .source import PACKAGE, ROOT

BUDGET = tomllib.loads((Path(__file__).parent / "budget.toml").read_text("utf-8"))


def files(folder: str, ending: str) -> list[Path]:
    found = (ROOT / folder).rglob(f"*{ending}")
    return [path for path in found if not {"__pycache__", "build", "_presets"} & set(path.relative_to(ROOT).parts)]


def lines(folder: str) -> int:
    return sum(len(path.read_text("utf-8").splitlines()) for path in files(folder, ".py"))


def words(folder: str) -> int:
    return sum(len(path.read_text("utf-8").split()) for path in files(folder, ".md"))


def test_no_part_has_more_lines_files_or_words_than_its_budget():
    found = {
        "lines": {folder: lines(folder) for folder in BUDGET["lines"]},
        "files": {folder: len(files(folder, ".py")) for folder in BUDGET["files"]},
        "words": {folder: words(folder) for folder in BUDGET["words"]},
    }
    above = {
        f"{measure} of {folder}": f"{count}, at most {BUDGET[measure][folder]}"
        for measure, counts in found.items()
        for folder, count in counts.items()
        if count > BUDGET[measure][folder]
    }
    assert not above, "tests/architecture/budget.toml says what a raise asks for"


def test_every_part_of_the_package_has_a_budget():
    parts = {f"magicsim/{path.parent.name}" for path in PACKAGE.glob("*/__init__.py")}
    assert parts <= set(BUDGET["lines"])
