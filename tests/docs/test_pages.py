"""What the pages say is there: commands that parse, names that import, files that exist."""

import ast
import importlib
import re
import shlex
import tomllib
from pathlib import Path

import pytest

import magicsim
from magicsim.cli import entry
from magicsim.cli.app import app
from magicsim.config.presets import EXPERIMENTS
from magicsim.geometry.objects.kinds import OBJECT_KINDS
from magicsim.geometry.objects.rigid_object import ObjectBase

from .pages import DOCS, EXAMPLES, PAGES, ROOT, blocks, name

assert entry  # registers the commands
COMMANDS = sorted(command for command in app if command[0] != "-" and app[command].show and command not in EXPERIMENTS)
DIRECTIVE = re.compile(r"^```\{command\} (?P<names>.+)$", re.MULTILINE)
SYMBOL = re.compile(r"`(magicsim(?:\.\w+)+)")
AUTODOC = re.compile(r"^\.\. auto\w+:: ([\w.]+)$", re.MULTILINE)
BESIDE = re.compile(r"((?:`[\w.]+`(?:, | and )?)+) (?:of|in|\()\s*`?(magicsim/[\w/]+\.py)`")
BRACKETS = re.compile(r"\((`[\w.]+`(?:, `[\w.]+`)*)[;)]")
PLACE = re.compile(
    r"`((?:tests|docs|benchmarks|detectors|geometry|scenes|deform|magicsim)/[\w./-]+\.(?:py|toml|md)|tests/[\w/]+)`"
)


def command_lines(page: Path) -> list[str]:
    lines = [line for block in blocks(page, "bash") for line in block.replace("\\\n", " ").splitlines()]
    parts = [part.strip() for line in lines for part in line.partition("#")[0].split("&&")]
    return [
        part.removeprefix(".venv/bin/") for part in parts if part.removeprefix(".venv/bin/").startswith("magicsim ")
    ]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_command_lines_parse(page: Path):
    for line in command_lines(page):
        words = shlex.split(line)[1:]
        if words[0] not in EXPERIMENTS:  # whose distribution may not be installed
            app.parse_args(words, exit_on_error=False, print_error=False)


def test_there_are_command_lines_to_parse():
    assert len([line for page in PAGES for line in command_lines(page)]) > 30


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_python_blocks_import_what_exists(page: Path):
    for block in blocks(page, "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                module = importlib.import_module(node.module)
                assert all(hasattr(module, alias.name) for alias in node.names)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_files_that_pages_name_exist(page: Path):
    places = set(PLACE.findall(page.read_text(encoding="utf-8")))
    assert not {place for place in places if not (ROOT / place).exists() and not (ROOT / "magicsim" / place).exists()}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_symbols_that_pages_name_exist(page: Path):
    text = page.read_text(encoding="utf-8")
    for symbol in {*AUTODOC.findall(text), *(SYMBOL.findall(text) if page.parent.name == "extending" else ())}:
        parts = symbol.split(".")
        found = importlib.import_module(parts[0])
        for count, part in enumerate(parts[1:], 2):
            if not hasattr(found, part):
                importlib.import_module(".".join(parts[:count]))
            found = getattr(found, part)


@pytest.mark.parametrize("page", [*sorted((DOCS / "extending").glob("*.md")), DOCS / "architecture.md"], ids=name)
def test_names_beside_a_file_stand_in_that_file(page: Path):
    for names, file in BESIDE.findall(page.read_text(encoding="utf-8")):
        text = (ROOT / file).read_text(encoding="utf-8")
        assert all(each in text for each in re.findall(r"`([\w.]+)`", names) for each in each.split(".")[-1:])


@pytest.mark.parametrize("page", sorted((DOCS / "physics").glob("*.md")), ids=name)
def test_names_in_brackets_on_pages_of_physics_are_in_the_package(page: Path):
    files = sorted((ROOT / "magicsim").rglob("*.py"))
    text = "\n".join(file.read_text(encoding="utf-8") for file in files)
    known = {part for file in files for part in file.relative_to(ROOT).with_suffix("").parts}
    known |= set(re.findall(r"^ *(?:def |class )?(\w+)[(:]", text, re.MULTILINE))
    names = [
        each for found in BRACKETS.findall(page.read_text(encoding="utf-8")) for each in re.findall(r"[\w.]+", found)
    ]
    assert {each for each in names if each.split(".")[-1] not in known} == set()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_one_page(command: str):
    pages = [
        page.name
        for page in (DOCS / "commands").glob("*.md")
        for found in DIRECTIVE.finditer(page.read_text(encoding="utf-8"))
        if command in found["names"].split(", ")
    ]
    assert len(pages) == 1, f"'{command}' stands on {pages}; docs/extending/index.md says how to add a page"


def test_pages_name_no_command_that_does_not_exist():
    texts = [page.read_text(encoding="utf-8") for page in (DOCS / "commands").glob("*.md")]
    named = {name for text in texts for found in DIRECTIVE.finditer(text) for name in found["names"].split(", ")}
    assert named <= set(COMMANDS)


@pytest.mark.parametrize("kind", OBJECT_KINDS)
def test_table_of_objects_lists_the_keys_of_each_kind(kind: str):
    text = (DOCS / "commands" / "index.md").read_text(encoding="utf-8")
    row = next(line for line in text.splitlines() if line.startswith(f"| `{kind}` |"))
    words = set(re.findall(r"`(\w+)`", row)) - {kind, "x", "y", "z", "8", "4x4x8"}
    assert words == set(OBJECT_KINDS[kind].model_fields) - set(ObjectBase.model_fields) - {"kind"}


def test_readme_is_read_to_its_end():
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 130
    assert {"<!-- demo -->", "<!-- test -->"} <= set(lines[:40])
    cells = [cell for line in lines if line.startswith("|") for cell in line.strip("|").split("|")]
    assert max(len(cell.split()) for cell in cells) <= 20


def test_contents_of_the_results_are_their_headings():
    text = (DOCS / "results.md").read_text(encoding="utf-8")
    listed = re.findall(r"^ *- \[(.+)\]\(#[\w-]+\)$", text, re.MULTILINE)
    assert listed == re.findall(r"^##+ (.+)$", text, re.MULTILINE)


def test_every_example_stands_in_the_gallery():
    gallery = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert all(script.name in gallery for script in EXAMPLES.glob("*.py"))


def test_layers_of_the_architecture_are_those_of_the_contract():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    [layers] = [each["layers"] for each in contracts if each["type"] == "layers"]
    held = [[part for part in layer.split(" : ") if not part.startswith("(")] for layer in layers[1:]]
    rows = (DOCS / "architecture.md").read_text(encoding="utf-8").partition("## Layers")[2].partition("## ")[0]
    assert [sorted(re.findall(r"`(\w+)`", row.split("|")[2])) for row in rows.splitlines() if "| `" in row] == held


def test_citation_is_of_this_version():
    assert f"\nversion: {magicsim.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


BESIDE_EXPERIMENTS = sorted((ROOT / "benchmarks" / "experiments" / "docs").rglob("*.md"))
SCRIPTS = sorted((ROOT / "benchmarks").glob("*.py"))
SHARED = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "benchmarks" / "laboratory").rglob("*.py"))
"""Options that several scripts have."""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_options_of_a_script_on_a_page_or_among_the_figures_are_its_own_and_all_that_it_needs(script: Path):
    source = script.read_text(encoding="utf-8")
    needed = set(re.findall(r'add_argument\(\s*"(--[\w-]+)"[^\n]*required=True', source))
    texts = [page.read_text(encoding="utf-8") for page in (*PAGES, *BESIDE_EXPERIMENTS)]
    texts.append((ROOT / "noxfile.py").read_text(encoding="utf-8").replace('"\n    "', ""))
    for line in re.findall(rf"python benchmarks/{script.name}([^`\"]*)[`\"]", "\n".join(texts)):
        given = set(re.findall(r"(?<!\S)(--[\w-]+)", line.partition("\n\n")[0]))
        unknown = {option for option in given if f'"{option}"' not in source + SHARED}
        assert not unknown, f"{script.name} has no {unknown}"
        assert needed <= given, f"{script.name}{line} lacks {needed - given}"
