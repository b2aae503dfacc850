"""Images side by side as HTML text."""

import base64
import io
from collections.abc import Sequence
from html import escape

from magicsim.arrays import Frame

SHOWN_PX = 180
"""Largest width of one image on the page [px]."""


def picture_row(pictures: Sequence[tuple[Frame, str]]) -> str:
    """Images in a row, each above its caption.

    Args:
        pictures: Images of shape (rows, columns, 3), and what stands below each.
    """
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
