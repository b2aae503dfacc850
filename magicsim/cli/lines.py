"""A result as lines for people: one a value, and a table for a list of alike things."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from magicsim.errors import visible

WIDE = 3
"""Keys of a thing above which a list of such things becomes a table with a head."""


def lines_of(values: Mapping[str, Any]) -> Iterator[str]:
    """Lines of a result."""
    for key, value in values.items():
        if isinstance(value, (list, tuple)) and value and all(isinstance(each, dict) for each in value):
            yield f"{key}:"
            yield from ("  " + line for line in _rows(value))
        else:
            yield f"{key}: {_cell(value)}"


def _rows(things: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    head = list(things[0])
    if len(head) <= WIDE or any(list(each) != head for each in things):
        return (": ".join(_cell(part) for part in each.values()) for each in things)
    table = [head, *([_cell(each[key]) for key in head] for each in things)]
    widths = [max(len(row[column]) for row in table) for column in range(len(head))]
    return ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table)


def _cell(value: object) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.6g}"
        case dict():
            return ", ".join(f"{key} {_cell(each)}" for key, each in value.items()) or "none"
        case list() | tuple():
            return (
                ", ".join(f"({_cell(each)})" if isinstance(each, (list, tuple)) else _cell(each) for each in value)
                or "none"
            )
        case _:
            return visible(str(value))
