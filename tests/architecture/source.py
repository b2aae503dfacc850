"""The package's modules as syntax trees."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "magicsim"
EXPERIMENTS = ROOT / "benchmarks" / "experiments" / "magicsim_experiments"


@cache
def modules(package: Path = PACKAGE) -> dict[str, ast.Module]:
    """Syntax tree of every module of a package, by its dotted name."""
    paths = sorted(package.rglob("*.py"))
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in paths if "_presets" not in path.parts}
    return {_name(path, package): tree for path, tree in trees.items()}


def _name(path: Path, package: Path) -> str:
    parts = path.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
