"""The page of a study: everything in one HTML file that needs no network, no script and no other file."""

import math
import re

import numpy as np
from markupsafe import Markup

from magicsim.report.text import MISSING, number, page_template
from magicsim_experiments.study.protocol import Study
from magicsim_experiments.study.result import Cell, Column, StudyResult

UNIT_ENDS = {"mm": "mm", "n": "N", "deg": "deg"}
"""Ends of headline keys that are units, as a page writes them."""
MANY = 13
"""Columns of a matrix from which its cells are small."""


def render_page(study: Study, found: StudyResult) -> str:
    """A whole HTML document."""
    config = study.config
    return page_template("study.html.jinja", "magicsim_experiments.study", "magicsim.report").render(
        title=f"Study: {config.kind.replace('-', ' ')}",
        facts={**found.facts, "Seed": str(config.seed)},
        headline={headed(name): shown(value) for name, value in found.headline.items()},
        tables=found.tables,
        matrices=[(each, each.counts / np.maximum(each.counts.sum(1, keepdims=True), 1)) for each in found.matrices],
        many=MANY,
        head=head,
        shown=shown,
        figures=[(each.title, each.note, Markup(each.svg)) for each in found.figures],
        notes=found.notes,
    )


def shown(value: Cell, digits: int = 3) -> str:
    """A value as text; numbers below what the digits show get three significant ones."""
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        small = math.isfinite(value) and 0 < abs(value) < 10.0**-digits
        return f"{value:.2e}" if small else number(value, digits)
    return str(value)


def in_words(name: str) -> str:
    """A key as words, such as `error of x mm`; points within numbers stay."""
    return re.sub(r"(?<!\d)\.|\.(?!\d)", " ", name.replace("_", " "))


def headed(name: str) -> str:
    """A key of the headline as words, its unit in brackets where the key ends with one."""
    head, _, end = name.rpartition("_")
    is_unit = end in UNIT_ENDS and head != "" and not head[-1].isdigit()
    return f"{in_words(head)} [{UNIT_ENDS[end]}]" if is_unit else in_words(name)


def head(column: Column) -> str:
    """Head of a column, its unit in brackets."""
    title = column.title or in_words(column.name.removesuffix(f"_{column.unit}") if column.unit else column.name)
    return f"{title} [{column.unit}]" if column.unit else title
