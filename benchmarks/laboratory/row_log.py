"""Rows of a benchmark told to the log as they are measured: some benchmarks take an hour."""

import logging
from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Row = TypeVar("Row", bound="DataclassInstance")
LOGGER = logging.getLogger(__name__)


def told(rows: Iterable[Row]) -> list[Row]:
    """All rows, each in a line of the log once it is there: its texts and numbers by name.

    Args:
        rows: Dataclasses, made one after the other.
    """
    found = []
    for row in rows:
        LOGGER.info("%s", ", ".join(_figures(asdict(row))))
        found.append(row)
    return found


def _figures(row: dict[str, Any]) -> Iterable[str]:
    for name, value in row.items():
        if isinstance(value, str | bool | int) or value is None:
            yield f"{name} {value}"
        elif isinstance(value, float):
            yield f"{name} {value:.4g}"
