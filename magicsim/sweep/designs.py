"""From a sweep to its designs, each with the values that make it."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

from magicsim.config import validate
from magicsim.dataset.points import unit_points
from magicsim.errors import ConfigError, unknown_choice
from magicsim.sweep.sensors import SweptSensor
from magicsim.sweep.sweep_file import SweepConfig

POINTS = 4
"""Stream of the quasi-random designs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SweptDesign:
    """One point of a sweep."""

    index: int
    values: dict[str, float]
    """Every field that any design of the sweep changes."""
    is_extra: bool
    """Whether it comes from `also`."""
    sensor: SweptSensor


def list_designs(sweep: SweepConfig) -> list[SweptDesign]:
    """All designs of a sweep: the last swept field changes fastest, then those of `also`.

    Raises:
        ConfigError: A field does not exist, is no number, or a value is out of its range.
    """
    names = [each.field for each in sweep.swept]
    if sweep.sampling == "grid":
        rows = list(product(*(each.on_grid() for each in sweep.swept)))
    else:
        points = unit_points(sweep.count or 1, len(names), seed=sweep.seed, stream=POINTS, sampling=sweep.sampling)
        spreads = [each.distribution() for each in sweep.swept]
        rows = [tuple(round(s.at(p), 6) for s, p in zip(spreads, point, strict=True)) for point in points.tolist()]
    every = list(dict.fromkeys([*names, *(name for extra in sweep.also for name in extra)]))
    base = {name: value_at(sweep, name) for name in every}
    points_of = [(base | dict(zip(names, row, strict=True)), False) for row in rows]
    points_of += [(base | extra, True) for extra in sweep.also]
    return [
        SweptDesign(index=index, values=values, is_extra=is_extra, sensor=sensor_at(sweep, values))
        for index, (values, is_extra) in enumerate(points_of)
    ]


def sensor_at(sweep: SweepConfig, values: Mapping[str, float]) -> SweptSensor:
    """The base sensor with some fields changed.

    Raises:
        ConfigError: As `list_designs`.
    """
    data = {"design": sweep.design.model_dump(), "rig": sweep.rig.model_dump(), "render": sweep.render.model_dump()}
    for field, value in values.items():
        place, last = _holder(data, field)
        old = place[last]
        place[last] = int(value) if isinstance(old, int) and float(value).is_integer() else value
    return validate(SweptSensor, data, source="sweep")


def value_at(sweep: SweepConfig, field: str) -> float:
    """What the base sensor has for a field.

    Raises:
        ConfigError: The field does not exist or is no number.
    """
    data = {"design": sweep.design.model_dump(), "rig": sweep.rig.model_dump(), "render": sweep.render.model_dump()}
    place, last = _holder(data, field)
    return float(place[last])


def _holder(data: dict[str, Any], field: str) -> tuple[Any, Any]:
    """The table or list that holds a field, and its key there."""
    holder: Any = data
    key: int | str = ""
    value: Any = data
    for part in field.split("."):
        if isinstance(value, tuple):  # a copy that can be changed takes its place
            value = holder[key] = list(value)
        is_list = isinstance(value, list)
        choices = (
            [str(place) for place in range(len(value))] if is_list else list(value) if isinstance(value, dict) else []
        )
        if part not in choices:
            raise ConfigError(unknown_choice(f"part of field '{field}'", part, choices))
        holder, key = value, int(part) if is_list else part
        value = holder[key]
    if isinstance(value, bool) or not isinstance(value, int | float | None):
        msg = f"field '{field}' is not allowed: must be a number, not {value!r}"
        raise ConfigError(msg)
    return holder, key
