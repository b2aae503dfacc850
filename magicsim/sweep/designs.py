"""From a sweep to its designs, each with the values that make it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from magicsim.config.models import validate
from magicsim.errors import ConfigError, unknown_choice
from magicsim.sampling.points import unit_points
from magicsim.sweep.sensors import SweptSensor
from magicsim.sweep.sweep_file import SweepConfig

POINTS = 4
"""Stream of the quasi-random designs."""
NUMBER: dict[type, str] = {int: "number", float: "number"}
NAME: dict[type, str] = {str: "name"}
"""What a field may hold that is to be set to either."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SweptDesign:
    """One point of a sweep."""

    index: int
    values: dict[str, float | str]
    """Every field that any design of the sweep changes."""
    is_extra: bool
    """Whether it comes from `also`."""
    sensor: SweptSensor


def count_designs(sweep: SweepConfig) -> int:
    """How many designs a sweep has; a search may choose one of them twice, and judges it once."""
    if sweep.sampling == "grid":
        return math.prod(len(each.on_grid()) for each in sweep.swept) + len(sweep.also)
    return (sweep.count or 1) + len(sweep.also)


def list_designs(sweep: SweepConfig) -> list[SweptDesign]:
    """All designs that are known beforehand: the last swept field changes fastest, then those of `also`.

    Of a search these are the ones of `also` alone; their numbers follow those of the designs that it chooses.

    Raises:
        ConfigError: A field does not exist, is no number, or a value is out of its range.
    """
    if sweep.sampling == "search":
        rows: list[dict[str, float | str]] = []
    elif sweep.sampling == "grid":
        names = [each.field for each in sweep.swept]
        rows = [dict(zip(names, row, strict=True)) for row in product(*(each.on_grid() for each in sweep.swept))]
    else:
        count, dimensions = sweep.count or 1, len(sweep.swept)
        points = unit_points(count, dimensions, seed=sweep.seed, stream=POINTS, sampling=sweep.sampling)
        rows = [values_at(sweep, point) for point in points.tolist()]
    first = count_designs(sweep) - len(sweep.also)
    return [
        *(design_with(sweep, index, row) for index, row in enumerate(rows)),
        *(design_with(sweep, index, row, is_extra=True) for index, row in enumerate(sweep.also, first)),
    ]


def values_at(sweep: SweepConfig, point: Sequence[float]) -> dict[str, float | str]:
    """The swept fields' values at a point of the unit cube, one number in 0..1 for each field."""
    return {each.field: each.at(p) for each, p in zip(sweep.swept, point, strict=True)}


def design_with(
    sweep: SweepConfig, index: int, changed: Mapping[str, float | str], *, is_extra: bool = False
) -> SweptDesign:
    """One design of a sweep: the base with some fields changed.

    Raises:
        ConfigError: As `list_designs`.
    """
    every = dict.fromkeys([*(each.field for each in sweep.swept), *(name for extra in sweep.also for name in extra)])
    values = {name: changed[name] if name in changed else value_at(sweep, name) for name in every}
    return SweptDesign(index=index, values=values, is_extra=is_extra, sensor=sensor_at(sweep, values))


def sensor_at(sweep: SweepConfig, values: Mapping[str, float | str]) -> SweptSensor:
    """The base sensor with some fields changed.

    Raises:
        ConfigError: As `list_designs`.
    """
    data = _base(sweep)
    for field, value in values.items():
        place, last = _holder(data, field, kinds=NAME if isinstance(value, str) else NUMBER)
        old = place[last]
        is_whole = isinstance(old, int) and isinstance(value, float) and value.is_integer()
        place[last] = int(value) if is_whole else value
    return validate(SweptSensor, data, source="sweep")


def value_at(sweep: SweepConfig, field: str) -> float | str:
    """What the base sensor has for a field.

    Raises:
        ConfigError: The field does not exist, is neither number nor name, or is left out.
    """
    data = _base(sweep)
    place, last = _holder(data, field, kinds=NUMBER | NAME)
    if place[last] is None:
        msg = f"field '{field}' has no value in the base sensor: give it one there, or in every design"
        raise ConfigError(msg)
    return place[last] if isinstance(place[last], str) else float(place[last])


def _base(sweep: SweepConfig) -> dict[str, Any]:
    return {"design": sweep.design.model_dump(), "rig": sweep.rig.model_dump(), "render": sweep.render.model_dump()}


def _holder(data: dict[str, Any], field: str, *, kinds: Mapping[type, str]) -> tuple[Any, Any]:
    """The table or list that holds a field, and its key there.

    Args:
        data: The base.
        field: Dotted name.
        kinds: What it may be.
    """
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
    if isinstance(value, bool) or not isinstance(value, (*kinds, type(None))):
        msg = f"field '{field}' is not allowed: must be a {' or a '.join(dict.fromkeys(kinds.values()))}, not {value!r}"
        raise ConfigError(msg)
    return holder, key
