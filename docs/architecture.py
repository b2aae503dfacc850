"""Draws the architecture in one picture, from what the modules import.

python docs/architecture.py                # writes docs/architecture.svg
"""

import ast
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "magicsim"
MAKES = {
    "wording": "text", "errors": "one line each", "conventions": "units, frames", "frame_class": "true classes",
    "config": "TOML to models", "folder": "whole results", "notebook": "tables, curves", "waiting": "signs of life",
    "sampling": "random numbers",
    "geometry": "meshes, distances", "camera": "8-bit frames", "scenes": "what happens",
    "deform": "displacements, forces", "light": "radiance",
    "simulation": "labelled frames", "workers": "many processes", "judge": "scored verdicts",
    "report": "pages", "fit": "fitted constants", "dataset": "shards", "robot": "live sensors",
    "evaluation": "detectors compared", "sweep": "designs compared",
    "learn": "models that read", "study": "experiments", "task": "closed loops",
    "live": "a window", "real": "recordings as data",
    "cli": "one function a command",
}  # fmt: skip
"""What each part makes."""
ASIDE, LINES = "detectors", ("NumPy and", "OpenCV alone:", "runs on a robot")
"""The part that imports the leaf and nothing else."""
UNSEEN = {"names", "arrays", ASIDE}
"""Parts without a place among the layers."""
WIDTH, ROW, GAP, LEFT, COLUMN, ASIDE_WIDTH = 760, 50, 14, 10, 620, 110


def parts_imported() -> dict[str, set[str]]:
    """Parts of the package that each part imports, imports inside functions included and those for typing left out."""
    found: dict[str, set[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        place = path.relative_to(PACKAGE).with_suffix("").parts
        if place[0] in {"__init__", "__main__", "_presets"}:
            continue
        names = {name.split(".")[1] for name in _imports(ast.parse(path.read_text(encoding="utf-8")))}
        found.setdefault(place[0], set()).update(names - {place[0]})
    return {part: needs & set(found) for part, needs in found.items()}


def layers(needs: Mapping[str, set[str]]) -> list[list[str]]:
    """Parts by how far above the leaf they are, lowest first; parts that need each other share a layer."""
    seen = {part: needs[part] - UNSEEN for part in needs if part not in UNSEEN}
    reach = {part: _reach(part, seen) for part in seen}
    circle = {part: frozenset({other for other in reach[part] if part in reach[other]} | {part}) for part in seen}
    height: dict[frozenset[str], int] = {}

    def rise(ring: frozenset[str]) -> int:
        below = {circle[other] for part in ring for other in seen[part]} - {ring}
        height[ring] = 1 + max((height[one] if one in height else rise(one) for one in below), default=-1)
        return height[ring]

    for ring in set(circle.values()):
        if ring not in height:
            rise(ring)
    return [sorted(part for part in seen if height[circle[part]] == level) for level in range(1 + max(height.values()))]


def picture() -> str:
    """The picture as SVG text."""
    needs = parts_imported()
    rows = layers(needs)[::-1]
    height = len(rows) * (ROW + GAP) + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" '
        'role="img" aria-label="Layers of the package">',
        f'<rect width="{WIDTH}" height="{height}" rx="8" fill="#ffffff"/>',
    ]
    for number, names in enumerate(rows):
        top, wide = GAP + number * (ROW + GAP), COLUMN / len(names)
        if number:
            parts.append(_arrow(LEFT + COLUMN / 2, top - GAP, top))
        for place, name in enumerate(names):
            left = LEFT + place * wide
            parts.append(_box(left, top, wide - (6 if place + 1 < len(names) else 0), "#e8eef7"))
            parts.append(_text(left + 8, top + 21, name, bold=True))
            parts.append(_text(left + 8, top + 40, MAKES.get(name, "")))
    users = [number for number, names in enumerate(rows) if any(ASIDE in needs[name] for name in names)]
    top, left = GAP + min(users) * (ROW + GAP), LEFT + COLUMN + 10
    parts.append(_box(left, top, ASIDE_WIDTH, "#f7eee3", tall=(len(users) - 1) * (ROW + GAP) + ROW))
    parts.append(_text(left + 8, top + 21, ASIDE, bold=True))
    parts += [_text(left + 8, top + 42 + 18 * number, line) for number, line in enumerate(LINES)]
    return "\n".join([*parts, "</svg>"]) + "\n"


def _imports(node: ast.AST) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        if isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names if alias.name.startswith("magicsim."))
        elif isinstance(child, ast.ImportFrom) and child.module == "magicsim":
            yield from (f"magicsim.{alias.name}" for alias in child.names)
        elif isinstance(child, ast.ImportFrom) and (child.module or "").startswith("magicsim."):
            yield str(child.module)
        yield from _imports(child)


def _reach(part: str, needs: Mapping[str, set[str]]) -> set[str]:
    found: set[str] = set()
    ahead = [part]
    while ahead:
        new = needs[ahead.pop()] - found
        found |= new
        ahead += new
    return found


def _box(left: float, top: float, width: float, colour: str, *, tall: float = ROW) -> str:
    shape = f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{tall:g}" rx="6"'
    return f'{shape} fill="{colour}" stroke="#5b6b82"/>'


def _text(left: float, baseline: float, text: str, *, bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{left:g}" y="{baseline:g}" font-size="13" fill="#1c2733"{weight}>{escape(text)}</text>'


def _arrow(x: float, top: float, bottom: float) -> str:
    tip = f"M {x - 4:g} {bottom - 5:g} L {x:g} {bottom - 1:g} L {x + 4:g} {bottom - 5:g}"
    return f'<path d="M {x:g} {top:g} L {x:g} {bottom - 1:g} {tip}" fill="none" stroke="#5b6b82" stroke-width="1.5"/>'


if __name__ == "__main__":
    Path(__file__).with_suffix(".svg").write_text(picture(), encoding="utf-8")
