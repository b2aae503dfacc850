"""How results show themselves in a notebook: small tables, curves and pictures that need nothing but the page."""

import base64
import io
from collections.abc import Mapping, Sequence
from html import escape

from magicsim.arrays import Frame

WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 360, 200, 56, 36, 12
LINE = "#0072b2"


def figures_table(title: str, figures: Mapping[str, object]) -> str:
    """A titled table of names and values."""
    rows = "".join(
        f'<tr><td style="text-align:left">{escape(name)}</td>'
        f'<td style="text-align:right">{escape(_shown(value))}</td></tr>'
        for name, value in figures.items()
    )
    return f"<div><b>{escape(title)}</b><table>{rows}</table></div>"


def curve(x: Sequence[float], y: Sequence[float], *, x_label: str, y_label: str) -> str:
    """Points joined by a line, both axes from zero or below, as SVG."""
    low_x, high_x, low_y, high_y = min(0.0, *x), max(*x, 1e-12), min(0.0, *y), max(0.0, *y)
    high_y = high_y if high_y > low_y else low_y + 1.0
    across = [LEFT + (WIDTH - LEFT - 12) * (each - low_x) / (high_x - low_x) for each in x]
    up = [HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (each - low_y) / (high_y - low_y) for each in y]
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True))
    dots = "".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{LINE}"/>' for a, b in zip(across, up, strict=True))
    base, right = HEIGHT - BOTTOM, WIDTH - 12
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" '
        f'font-size="12" role="img" aria-label="{escape(y_label)} against {escape(x_label)}">'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>'
        f'<path d="M {LEFT} {TOP} V {base} H {right}" fill="none" stroke="#555555"/>'
        f'<polyline points="{points}" fill="none" stroke="{LINE}" stroke-width="2"/>{dots}'
        f'<text x="{LEFT}" y="{base + 15}">{low_x:.3g}</text>'
        f'<text x="{right}" y="{base + 15}" text-anchor="end">{high_x:.3g}</text>'
        f'<text x="{(LEFT + right) / 2:g}" y="{HEIGHT - 6}" text-anchor="middle">{escape(x_label)}</text>'
        f'<text x="{LEFT - 5}" y="{base}" text-anchor="end">{low_y:.3g}</text>'
        f'<text x="{LEFT - 5}" y="{TOP + 10}" text-anchor="end">{high_y:.3g}</text>'
        f'<text transform="translate(14 {(TOP + base) / 2:g}) rotate(-90)" text-anchor="middle">'
        f"{escape(y_label)}</text>"
        "</svg>"
    )


def _shown(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


SHOWN_PX = 180
"""Largest width of one image on the page [px]."""


def picture_row(pictures: Sequence[tuple[Frame, str]]) -> str:
    """Images in a row, each above its caption."""
    cells = "".join(
        f'<figure style="margin:0 6px 6px 0"><img style="width:100%" alt="{escape(caption)}" src="{_address(image)}"/>'
        f'<figcaption style="font-size:80%">{escape(caption)}</figcaption></figure>'
        for image, caption in pictures
    )
    columns = f"repeat({len(pictures)}, minmax(0, {SHOWN_PX}px))"
    return f'<div style="display:grid;grid-template-columns:{columns}">{cells}</div>'


def _address(image: Frame) -> str:
    from PIL import Image as Pillow

    buffer = io.BytesIO()
    Pillow.fromarray(image).save(buffer, format="PNG")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
