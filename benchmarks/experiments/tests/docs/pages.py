"""The pages of the experiments, and the scripts beside them."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

ROOM = Path(__file__).resolve().parents[2]
DOCS = ROOM / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), ROOM / "README.md"])
FENCE = re.compile(r"^```(?P<language>\w+)\n(?P<code>.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    found = FENCE.finditer(page.read_text(encoding="utf-8"))
    return [match["code"] for match in found if match["language"] == language]


def load(script: Path) -> ModuleType:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(f"docs_{script.stem}", script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
