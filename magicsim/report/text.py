"""What pages are written with: templates, pictures, numbers and names."""

import base64
import io
import math
from pathlib import PurePath

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup
from PIL import Image

from magicsim.arrays import Frame
from magicsim.errors import visible


def page_template(name: str, *packages: str) -> Template:
    """A template and those it includes: everything is escaped, and a value that is not given is an error.

    Characters that hide or turn text around, such as bidirectional marks in a name, are spelt out.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package, ".") for package in packages]),
        autoescape=True,
        finalize=_shown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(name)


def _shown(value: object) -> object:
    return visible(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def data_uri(image: Frame) -> str:
    """A frame, shape (rows, columns, 3), as an address that holds the picture itself, in WebP."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="WEBP", quality=90, method=4)
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


MISSING = "\u2013"
"""Stands for a value that does not exist."""
MINUS = "\u2212"
"""Sign of a negative number."""
_SPACE = "\u00a0"


def number(value: float | None, digits: int = 2) -> str:
    """A number with a fixed count of decimals, or a dash where there is none."""
    if value is None or not math.isfinite(value):
        return MISSING
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text.replace("-", MINUS)


def quantity(value: float | None, unit: str, digits: int = 2) -> str:
    """A number with its unit, or a dash where there is none."""
    text = number(value, digits)
    return text if text == MISSING else f"{text}{_SPACE}{unit}"


def scientific(value: float | None) -> str:
    """A small number with two significant digits, such as 3.1e-07."""
    return MISSING if value is None or not math.isfinite(value) else f"{value:.1e}"


def percent(share: float | None, digits: int = 1) -> str:
    """A share in 0..1 as a percentage, or a dash where there is none."""
    return MISSING if share is None else quantity(100.0 * share, "%", digits)


def gap_or_depth(gap_mm: float | None) -> str:
    """The gap of an object, its depth where it is pressed, or that there is none [mm]."""
    if gap_mm is None:
        return "no object"
    return f"gap {quantity(gap_mm, 'mm')}" if gap_mm > 0.0 else f"depth {quantity(-gap_mm, 'mm')}"


def span(first: int, last: int) -> str:
    """One frame or several neighbouring ones, by number."""
    return f"frame {first}" if first == last else f"frames {first}\u2013{last}"


def short_name(name: str) -> str:
    """A preset's name as it is; of a path, the last part."""
    return PurePath(name.replace("\\", "/")).name
