"""The package's modules as syntax trees, and what each of them imports."""

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "magicsim"


@cache
def modules() -> dict[str, ast.Module]:
    """Syntax tree of every module of the package, by its dotted name."""
    paths = sorted(PACKAGE.rglob("*.py"))
    return {_name(path): ast.parse(path.read_text(encoding="utf-8")) for path in paths if "_presets" not in path.parts}


def imports(tree: ast.AST) -> set[str]:
    """Dotted names of all modules that a tree imports, anywhere in it; for typing alone does not count."""
    found: set[str] = set()
    for node in _runtime_nodes(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            inner = {f"{module}.{alias.name}" for alias in node.names} & set(modules())
            found |= inner or {module}
    return found


def top_level_imports(tree: ast.Module) -> set[str]:
    """Dotted names of the modules that are imported as soon as a module is."""
    statements = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    return imports(ast.Module(body=list(statements), type_ignores=[]))


def _runtime_nodes(tree: ast.AST) -> list[ast.AST]:
    nodes = [tree]
    for child in ast.iter_child_nodes(tree):
        for_typing = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
        nodes += [] if for_typing else _runtime_nodes(child)
    return nodes


def _name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
