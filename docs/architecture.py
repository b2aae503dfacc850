"""Draws the architecture in one picture.

python docs/architecture.py                # writes docs/architecture.svg
"""

from html import escape
from pathlib import Path

LAYERS = (
    (("cli",), "one function a command"),
    (("judge", "evaluation", "sweep", "bench"), "verdicts, comparisons, figures"),
    (("dataset", "fit", "robot", "report"), "datasets, devices, pages"),
    (("simulation", "workers"), "labelled frames, on many processes"),
    (("light",), "radiance of one state of one sensor"),
    (("scenes", "camera", "deform"), "what happens, 8-bit frames, displacements"),
    (("geometry", "sampling"), "designs, objects, meshes; random numbers"),
    (("config", "folder", "errors", "conventions"), "the leaf: no part of the package below"),
)
"""Parts of the package from top to bottom, and what each layer makes; a layer imports those below it."""
ASIDE = ("detectors", ("NumPy and", "OpenCV", "alone: runs", "on a robot"))
"""The part that imports the leaf and nothing else; layers from `ASIDE_TOP` upwards may import it."""
ASIDE_TOP, ASIDE_BOTTOM = 2, 6
"""Layers beside which it stands."""
WIDTH, ROW, GAP, LEFT, COLUMN = 520, 50, 14, 10, 390


def picture() -> str:
    """The picture as SVG text."""
    height = len(LAYERS) * (ROW + GAP) + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" '
        'role="img" aria-label="Layers of the package">',
        f'<rect width="{WIDTH}" height="{height}" rx="8" fill="#ffffff"/>',
    ]
    for number, (names, makes) in enumerate(LAYERS):
        top = GAP + number * (ROW + GAP)
        is_leaf = number == len(LAYERS) - 1
        parts.append(_box(LEFT, top, WIDTH - 2 * LEFT if is_leaf else COLUMN, ROW, "#e8eef7"))
        parts.append(_text(LEFT + 12, top + 21, " · ".join(names), bold=True))
        parts.append(_text(LEFT + 12, top + 40, makes))
        if number:
            parts.append(_arrow(LEFT + COLUMN / 2, top - GAP, top))
    name, lines = ASIDE
    left, top = LEFT + COLUMN + 10, GAP + ASIDE_TOP * (ROW + GAP)
    tall = (ASIDE_BOTTOM - ASIDE_TOP + 1) * (ROW + GAP) - GAP
    parts.append(_box(left, top, WIDTH - left - LEFT, tall, "#f7eee3"))
    parts.append(_text(left + 10, top + 24, name, bold=True))
    parts += [_text(left + 10, top + 48 + 18 * number, line) for number, line in enumerate(lines)]
    parts.append(_arrow((left + WIDTH - LEFT) / 2, top + tall, top + tall + GAP))
    return "\n".join([*parts, "</svg>"]) + "\n"


def _box(left: float, top: float, width: float, height: float, colour: str) -> str:
    shape = f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}" rx="6"'
    return f'{shape} fill="{colour}" stroke="#5b6b82"/>'


def _text(left: float, baseline: float, text: str, *, bold: bool = False) -> str:
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{left:g}" y="{baseline:g}" font-size="14" fill="#1c2733"{weight}>{escape(text)}</text>'


def _arrow(x: float, top: float, bottom: float) -> str:
    tip = f"M {x - 4:g} {bottom - 5:g} L {x:g} {bottom - 1:g} L {x + 4:g} {bottom - 5:g}"
    return f'<path d="M {x:g} {top:g} L {x:g} {bottom - 1:g} {tip}" fill="none" stroke="#5b6b82" stroke-width="1.5"/>'


if __name__ == "__main__":
    Path(__file__).with_suffix(".svg").write_text(picture(), encoding="utf-8")
