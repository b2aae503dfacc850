"""From a sweep to its designs, each with the values that make it, and to the renderings that a design is seen in.

Rooms, cameras and prints of renderings are alike for all designs: they are drawn as a dataset's recipe draws them, from
the sweep's seed and the number of the rendering, so that two designs differ by what is swept and by nothing else.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from magicsim.camera.camera import Camera
from magicsim.config.models import Config, validate
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.entries import ClearPath
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import ConfigError, unknown_choice
from magicsim.geometry.design import ElastomerDesign
from magicsim.sampling.distribution import unit_points
from magicsim.scenes.rig import Rig, in_room
from magicsim.scenes.scene import RenderSettings
from magicsim.sweep.measures import SweepQuality
from magicsim.sweep.sweep_file import OF_QUALITY, SweepConfig


class SweptSensor(Config):
    """Everything that a sweep may change; fields are named `design.skin_mm`, `rig.camera.gamma`, `render.facet_mm`."""

    design: ElastomerDesign
    rig: Rig
    render: RenderSettings = RenderSettings()


def camera_of(sensor: SweptSensor, quality: SweepQuality, *, scale: int = 1) -> Camera:
    """The sensor's camera with about as many pixels as the quality asks for.

    The shape of its image, its field and its noise a pixel stay.
    """
    camera = sensor.rig.camera
    share = scale * math.sqrt(quality.columns * quality.rows / (camera.columns * camera.rows))
    columns, rows = round(share * camera.columns), round(share * camera.rows)
    x, y = camera.principal_offset_px
    offset = (x * columns / camera.columns, y * rows / camera.rows)
    return camera.model_copy(update={"columns": columns, "rows": rows, "principal_offset_px": offset})


def render_of(sensor: SweptSensor, quality: SweepQuality) -> RenderSettings:
    """The sensor's rendering at the quality's samples and particles."""
    return sensor.render.model_copy(update={name: getattr(quality, name) for name in OF_QUALITY})


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
    """One design of a sweep: the base with some fields changed."""
    every = dict.fromkeys([*(each.field for each in sweep.swept), *(name for extra in sweep.also for name in extra)])
    values = {name: changed[name] if name in changed else value_at(sweep, name) for name in every}
    return SweptDesign(index=index, values=values, is_extra=is_extra, sensor=sensor_at(sweep, values))


def sensor_at(sweep: SweepConfig, values: Mapping[str, float | str]) -> SweptSensor:
    """The base sensor with some fields changed."""
    data = _base(sweep)
    for field, value in values.items():
        place, last = _holder(data, field, kinds=NAME if isinstance(value, str) else NUMBER)
        old = place[last]
        is_whole = isinstance(old, int) and isinstance(value, float) and value.is_integer()
        place[last] = int(value) if is_whole else value
    return validate(SweptSensor, data, source="sweep")


def value_at(sweep: SweepConfig, field: str) -> float | str:
    """The base sensor's value of a field.

    Raises:
        ConfigError: The field does not exist, is neither number nor name, or is left out.
    """
    data = _base(sweep)
    place, last = _holder(data, field, kinds=NUMBER | NAME)
    if place[last] is None:
        raise ConfigError(f"field '{field}' has no value in the base sensor: give it one there, or in every design")
    return place[last] if isinstance(place[last], str) else float(place[last])


def _base(sweep: SweepConfig) -> dict[str, Any]:
    return sweep.model_dump(mode="json", include={"design", "rig", "render"})


def _holder(data: dict[str, Any], field: str, *, kinds: Mapping[type, str]) -> tuple[Any, Any]:
    """The table or list that holds a field, and its key there."""
    holder: Any = {}
    key: int | str = ""
    value: Any = data
    for part in field.split("."):
        keys = range(len(value)) if isinstance(value, list) else value if isinstance(value, dict) else ()
        choices = {str(each): each for each in keys}
        if part not in choices:
            raise ConfigError(unknown_choice(f"part of field '{field}'", part, choices))
        holder, key = value, choices[part]
        value = holder[key]
    if isinstance(value, bool) or not isinstance(value, (*kinds, type(None))):
        msg = f"field '{field}' is not allowed: must be a {' or a '.join(dict.fromkeys(kinds.values()))}, not {value!r}"
        raise ConfigError(msg)
    return holder, key


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignRendering:
    """A sensor as one rendering sees it."""

    sensor: SweptSensor
    drawn: dict[str, float]
    """What it has of its own, by the names that rows of a dataset give it."""


def renderings_of(sensor: SweptSensor, sweep: SweepConfig) -> list[DesignRendering]:
    """A design as each of `quality.renderings` sees it; all alike where a sweep names no rooms and draws nothing.

    Raises:
        ConfigError: A drawn print or camera is not allowed.
    """
    rooms, alike = sweep.rooms, [DesignRendering(sensor=sensor, drawn={})] * sweep.quality.renderings
    if not (rooms or sweep.draws):
        return alike
    renderings = []
    for turn, each in enumerate(_drawn(sensor, sweep) if sweep.draws else alike):
        rig = in_room(each.sensor.rig, rooms[turn % len(rooms)]) if rooms else each.sensor.rig
        camera = rig.camera.model_copy(update={"pattern_seed": sensor.rig.camera.pattern_seed + turn})
        seen = each.sensor.model_copy(update={"rig": rig.model_copy(update={"camera": camera})})
        drawn = each.drawn | {"camera.pattern_seed": float(camera.pattern_seed)}
        renderings.append(DesignRendering(sensor=seen, drawn=drawn))
    return renderings


def rows_of_renderings(found: list[DesignRendering]) -> dict[str, float]:
    """What renderings have of their own, as columns of a table: `renderings.0.camera.full_well_e` and so on."""
    return {f"renderings.{turn}.{name}": value for turn, each in enumerate(found) for name, value in each.drawn.items()}


def _drawn(sensor: SweptSensor, sweep: SweepConfig) -> list[DesignRendering]:
    """Prints and cameras of the renderings."""
    recipe = Recipe(
        schema_version=1, design=sensor.design, rig=sensor.rig, seed=sweep.seed, episodes=sweep.quality.renderings,
        episodes_per_sensor=1, tolerances=sweep.tolerances, camera=sweep.camera, paths=(ClearPath(kind="clear"),),
    )  # fmt: skip
    shape = {"unevenness": sensor.design.unevenness}  # a recipe's next unit has another
    renderings = []
    for each in draw_episodes(recipe):
        update = {"design": each.scene.design.model_copy(update=shape), "rig": each.scene.rig}
        renderings.append(DesignRendering(sensor=sensor.model_copy(update=update), drawn=each.values))
    return renderings
