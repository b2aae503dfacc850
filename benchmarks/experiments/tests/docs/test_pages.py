"""What the pages say is there: commands that parse, names that import, links that lead somewhere."""

import ast
import importlib
import re
import shlex
from pathlib import Path

import pytest

from magicsim.cli.entry import app

from .pages import PAGES, ROOM, blocks

LINK = re.compile(r"\]\((?!https?:)(?P<target>[^)#]+)")


def name(page: Path) -> str:
    return page.relative_to(ROOM).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_command_lines_parse(page: Path):
    lines = [line for block in blocks(page, "bash") for line in block.replace("\\\n", " ").splitlines()]
    for line in (line.partition("#")[0].strip() for line in lines):
        if line.startswith("magicsim "):
            app.parse_args(shlex.split(line)[1:], exit_on_error=False, print_error=False)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_python_blocks_import_what_exists(page: Path):
    for block in blocks(page, "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                module = importlib.import_module(node.module)
                assert all(hasattr(module, alias.name) for alias in node.names)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_to_files(page: Path):
    targets = [found["target"] for found in LINK.finditer(page.read_text(encoding="utf-8"))]
    assert not [target for target in targets if not (page.parent / target).exists()]
