"""From a recipe to what is simulated: printed sensors, and episodes on them, each with its values.

Both are drawn when they are asked for, so that it does not matter how many there are.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar, overload

import numpy as np

from magicsim.arrays import Array
from magicsim.config.models import validate
from magicsim.dataset.recipes.entries import ClearPath, FlashlightPath, HoverPath, TouchPath
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE, ElastomerDesign
from magicsim.sampling.distribution import Distribution, Number, UnitPoints, choose
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import OutputSettings, SceneConfig

Values = dict[str, float]
Bounds = Mapping[str, tuple[float, float]]
"""Smallest and largest value of some numbers by name."""
DrawnT = TypeVar("DrawnT")
SENSORS, EPISODES = 1, 2
"""Streams of points."""
CHOICES = 3
"""Dimensions of an episode's point that choose: the path, the object, the mesh file."""
ROOM_CHOICES = 1
"""Dimensions of a sensor's point that choose its room."""
FLAWS = (
    ("roughness", "skin", "skin_roughness"), ("roughness", "walls", "wall_roughness"),
    ("inclusions", "bubbles_per_mm3", "bubbles_per_mm3"), ("inclusions", "flakes_per_mm3", "flakes_per_mm3"),
    ("unevenness", "wall_sd_mm", "wall_spread_mm"), ("unevenness", "wave_sd_mm", "wave_mm"),
    ("unevenness", "skin_sd_mm", "skin_spread_mm"), ("unevenness", "torn_share", "torn_share"),
)  # fmt: skip
"""Tables of a design that drawn values of a print are added to, their keys there, and the names of the values."""
SEEDED = ("unevenness", "inclusions")
"""Tables among them that have a seed."""
PLACE = ("x_mm", "y_mm")
CHANNELS = ("red", "green", "blue")
KEPT = 64
"""Things that were drawn last, which are not drawn again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnSensor:
    """One printed sensor."""

    index: int
    design: ElastomerDesign
    rig: Rig
    values: Values


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnEpisode:
    """One episode, ready to be simulated."""

    index: int
    sensor: int
    path_kind: str
    values: Values
    """Drawn values by name, those of its sensor included."""
    scene: SceneConfig
    """What happens; where a press ends at a force it goes to the largest depth here, see `magicsim.dataset.rows`."""
    force_n: float | None = None
    """Normal force at which its press ends [N]; None where it ends at a depth."""
    must_reach: bool = False
    """Whether an object that does not reach that force is refused: no depth was asked for beside it."""


def episode_seed(seed: int, index: int) -> int:
    """Seed of one episode of a recipe, from `SeedSequence([seed, index])`, below 2^31."""
    return int(np.random.SeedSequence([seed, index]).generate_state(1)[0]) >> 1


def sensor_of(recipe: Recipe, index: int) -> int:
    """Number of the sensor that an episode is on."""
    return index // recipe.episodes_per_sensor


class Drawn(Sequence[DrawnT]):
    """Things that are drawn one by one as they are asked for; what one of them is never depends on the others."""

    def __init__(self, count: int, draw: Callable[[int], DrawnT]) -> None:
        """Takes their number, and what draws one by its number."""
        self._count, self._draw = count, lru_cache(maxsize=KEPT)(draw)

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, place: int) -> DrawnT: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[DrawnT]: ...
    def __getitem__(self, place: int | slice) -> DrawnT | Sequence[DrawnT]:
        if isinstance(place, slice):
            return [self._draw(each) for each in range(*place.indices(self._count))]
        return self._draw(range(self._count)[place])

    def __iter__(self) -> Iterator[DrawnT]:
        return (self._draw(place) for place in range(self._count))


def draw_sensors(recipe: Recipe, count: int) -> Drawn[DrawnSensor]:
    """The first sensors of a recipe; a drawn design that is not allowed is an error when it is asked for."""
    numbers = _tolerances(recipe)
    printed = len(_varying(numbers))
    rooms = [len(_varying(each.numbers())) for each in recipe.rooms]
    points = _points(recipe, printed + (ROOM_CHOICES + max(rooms) if rooms else 0), SENSORS)
    ends = [printed, printed + ROOM_CHOICES]
    return Drawn(count, lambda index: _sensor(recipe, index, numbers, np.split(points[index], ends)))


def draw_episodes(recipe: Recipe) -> Drawn[DrawnEpisode]:
    """All episodes of a recipe, the first ones always the same; what is not allowed is an error once asked for."""
    sensors = draw_sensors(recipe, sensor_of(recipe, recipe.episodes - 1) + 1)
    bounds = _place_bounds(recipe)
    camera = len(_varying(_camera(recipe)))
    objects = max((len(_varying(each.numbers())) for each in recipe.objects), default=0)
    paths = max(len(_varying(each.numbers())) for each in recipe.paths)
    points = _points(recipe, CHOICES + camera + objects + paths, EPISODES)
    differ = differing_units(recipe, 2) > 1
    ends = np.cumsum([CHOICES, camera, objects])
    return Drawn(
        recipe.episodes,
        lambda index: _episode(
            recipe, index, sensors[sensor_of(recipe, index)], np.split(points[index], ends), bounds, differ=differ
        ),
    )


def _place_bounds(recipe: Recipe) -> Bounds:
    """Ranges of places in the picture to come down at, none where it may be left; `ConfigError` with no place."""
    if not recipe.inside or not any(isinstance(path, TouchPath | HoverPath) for path in recipe.paths):
        return {}
    from magicsim.camera.projection import picture_mm

    low, high = picture_mm(recipe.design, recipe.rig.lens, recipe.rig.camera).tolist()
    bounds = dict(zip(PLACE, zip(low, high, strict=True), strict=True))
    for number, path in enumerate(recipe.paths):
        for name, (least, most) in bounds.items():
            drawn = getattr(path, name, None)
            try:
                _ = drawn.at(0.0, least, most) if isinstance(drawn, Distribution) else None
            except ValueError:
                raise ConfigError(
                    f"paths.{number}.{name} is not allowed: all of it is outside of the picture, which covers "
                    f"{least:.3g} to {most:.3g} mm; inside = false keeps it"
                ) from None
    return bounds


def drawn_names(recipe: Recipe) -> list[str]:
    """Names of all values that an episode of the recipe may have, sorted."""
    groups = [("sensor", _tolerances(recipe)), ("camera", _camera(recipe))]
    for group, entries in (("sensor", recipe.rooms), ("object", recipe.objects), ("path", recipe.paths)):
        groups += [(group, entry.numbers()) for entry in entries]
    return sorted({f"{group}.{name}" for group, numbers in groups for name in _varying(numbers)})


def _points(recipe: Recipe, dimensions: int, stream: int) -> UnitPoints:
    return UnitPoints(dimensions, seed=recipe.seed, stream=stream, sampling=recipe.sampling)


def _varying(numbers: Mapping[str, Number]) -> list[str]:
    """Names of the numbers that are drawn."""
    return [name for name, number in numbers.items() if isinstance(number, Distribution)]


def _drawer(group: str, point: Array, values: Values, bounds: Bounds | None = None) -> Callable[[str, Number], float]:
    """A function that takes the next coordinate for every distribution, and notes what came out, within its bounds."""
    shares = iter(point.tolist())

    def draw(name: str, number: Number) -> float:
        if not isinstance(number, Distribution):
            return float(number)
        value = number.at(next(shares), *(bounds or {}).get(name, ()))
        values[f"{group}.{name}"] = round(value, 9)
        return values[f"{group}.{name}"]

    return draw


def _tolerances(recipe: Recipe) -> dict[str, Number]:
    tolerances, lights = recipe.tolerances, range(len(recipe.rig.lamps))
    several: dict[str, Sequence[object]] = {
        "led_strength": lights,
        "led_color": [f"{number}.{channel}" for number in lights for channel in CHANNELS],
        "pitch_scale": "xyz",
        "pitch_drift": "xyz",
    }
    numbers = {name: getattr(tolerances, name) for name in type(tolerances).model_fields if name not in several}
    return numbers | {f"{name}.{of}": getattr(tolerances, name) for name, all_of in several.items() for of in all_of}


def _flawed(design: Mapping[str, Any]) -> list[str]:
    """Tables of a design whose seeds matter: another print has other flaws."""
    return [each for each in SEEDED if any(design[table][key] for table, key, _ in FLAWS if table == each)]


def differing_units(recipe: Recipe, count: int) -> int:
    """How many of so many printed sensors look different at rest: one, where nothing is drawn for them."""
    rooms = len(recipe.rooms) > 1 or any(_varying(each.numbers()) for each in recipe.rooms)
    tolerances = bool(_varying(_tolerances(recipe)))
    return count if rooms or tolerances or _flawed(draw_sensors(recipe, 1)[0].design.model_dump()) else min(count, 1)


def _camera(recipe: Recipe) -> dict[str, Number]:
    fields = {name: getattr(recipe.camera, name) for name in type(recipe.camera).model_fields}
    return {name: number for name, number in fields.items() if number is not None}


def _sensor(recipe: Recipe, index: int, numbers: dict[str, Number], parts: list[Array]) -> DrawnSensor:
    printed, choice, room = parts
    values: Values = {}
    draw = _drawer("sensor", printed, values)
    drawn = {name: draw(name, number) for name, number in numbers.items()}
    design = recipe.design.model_dump()
    design["skin_mm"] = round(design["skin_mm"] + drawn["skin_mm"], 9)
    if recipe.design.has_grid:
        design["wall_mm"] = round(design["wall_mm"] + drawn["wall_mm"], 9)
        design["cell_mm"] = round(design["cell_mm"] - drawn["wall_mm"], 9)
    for table, key, name in FLAWS:
        design[table][key] = round(design[table][key] + drawn[name], 9)
    uneven = design["unevenness"]
    pitches = zip("xyz", uneven["pitch_scale"], uneven["pitch_drift"], strict=True)
    scaled = [(a * drawn[f"pitch_scale.{axis}"], b + drawn[f"pitch_drift.{axis}"]) for axis, a, b in pitches]
    uneven["pitch_scale"], uneven["pitch_drift"] = zip(*scaled, strict=True)
    # A print without flaws has nothing to draw by a seed: units that differ in nothing are one, rendered once.
    for table in _flawed(design):
        design[table]["seed"] += index
    for name, material in design["materials"].items():
        if material is None:
            continue
        material["ior"] = round(material["ior"] + drawn[f"{name}_ior"], 9)
        for modulus in ("youngs_modulus_mpa", "shear_modulus_mpa", "bulk_modulus_mpa"):
            if modulus in material:
                material[modulus] *= drawn["stiffness"]
        for term in material.get("prony", ()):
            term["modulus_mpa"] *= drawn["stiffness"]
    rig = recipe.rig.model_dump()
    rings = [rig["ring"]] if rig["ring"] is not None else []
    for number, light in enumerate([*rig["strips"], *rig["leds"], *rings]):
        colors = [drawn[f"led_color.{number}.{channel}"] for channel in CHANNELS]
        strength = drawn[f"led_strength.{number}"]
        light["radiance"] = tuple(
            strength * each * color for each, color in zip(light["radiance"], colors, strict=True)
        )
    rig["camera"]["pattern_seed"] = recipe.rig.camera.pattern_seed + index
    if recipe.rooms:
        entry = recipe.rooms[choose(float(choice[0]), tuple(each.weight for each in recipe.rooms))]
        rig = entry.placed(rig, _drawer("sensor", room, values))
    return DrawnSensor(
        index=index,
        design=validate(ElastomerDesign, design, source=f"sensor {index}"),
        rig=validate(Rig, rig, source=f"sensor {index}"),
        values=values,
    )


def _episode(
    recipe: Recipe, index: int, sensor: DrawnSensor, parts: list[Array], bounds: Bounds, *, differ: bool
) -> DrawnEpisode:  # fmt: skip
    """One episode; `differ` says whether units look different at rest."""
    choices, camera, objects, paths = parts
    values = dict(sensor.values)
    source = f"episode {index}"
    path = recipe.paths[choose(float(choices[0]), tuple(each.weight for each in recipe.paths))]
    draw = _drawer("path", paths, values, bounds)
    drawn = {name: draw(name, number) for name, number in path.numbers().items()}
    force, must_reach = drawn.get("force_n"), isinstance(path, TouchPath) and path.depth_mm is None
    if must_reach:
        drawn["depth_mm"] = min(sensor.design.limits.depth_mm or math.inf, MAX_DEPTH_SHARE * sensor.design.height_mm)
    rig = sensor.rig.model_dump()
    indenter = None
    if isinstance(path, FlashlightPath):
        rig["flashlight"]["radiance"] = tuple(drawn["strength"] * each for each in rig["flashlight"]["radiance"])
    elif not isinstance(path, ClearPath):
        entry = recipe.objects[choose(float(choices[1]), tuple(each.weight for each in recipe.objects))]
        indenter = entry.draw(_drawer("object", objects, values), float(choices[2]))
    note = _drawer("camera", camera, values)
    seen = {name: note(name, number) for name, number in _camera(recipe).items()}
    rig["camera"] = recipe.camera.placed(rig["camera"], seen)
    friction = drawn["friction"] if isinstance(path, TouchPath) else 0.0
    # The noise of an untouched image stands still in all frames of a unit: units that differ do not share it.
    anchor = recipe.render.anchor_seed + (sensor.index if differ else 0)
    scene = {
        "schema_version": 1,
        "design": sensor.design,
        "rig": rig,
        "seed": episode_seed(recipe.seed, index),
        "references": recipe.references,
        "frames_per_second": recipe.frames_per_second,
        "object": indenter,
        "contact": recipe.contact.model_dump() | {"friction": friction},
        "render": recipe.render.model_copy(update={"anchor_seed": anchor}),
        "output": OutputSettings(**recipe.labels.model_dump(), preview=False, report=False),
        "keyframes": path.keyframes(drawn),
    }
    return DrawnEpisode(
        index=index,
        sensor=sensor.index,
        path_kind=path.kind,
        values=values,
        scene=validate(SceneConfig, scene, source=source),
        force_n=force,
        must_reach=must_reach,
    )
