"""What each rendering of a design sees it with: a room, a camera and a print of its own, alike for all designs.

Cameras and prints are drawn as a dataset's recipe draws them, from the sweep's seed and the number of the rendering, so
that two designs differ by what is swept and by nothing else.
"""

from dataclasses import dataclass

from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.path_recipe import ClearPath
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.scenes.rig import in_room
from magicsim.sweep.sensors import SweptSensor
from magicsim.sweep.sweep_file import SweepConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class Rendering:
    """A sensor as one rendering sees it."""

    sensor: SweptSensor
    drawn: dict[str, float]
    """What it has of its own, by the names that rows of a dataset give it."""


def renderings_of(sensor: SweptSensor, sweep: SweepConfig) -> list[Rendering]:
    """A design as each of `quality.renderings` sees it; all alike where a sweep names no rooms and draws nothing.

    Raises:
        ConfigError: A drawn print or camera is not allowed.
    """
    count, rooms = sweep.quality.renderings, sweep.rooms
    if not (rooms or sweep.draws):
        return [Rendering(sensor=sensor, drawn={})] * count
    found = []
    for turn, each in enumerate(_drawn(sensor, sweep)):
        rig = in_room(each.sensor.rig, rooms[turn % len(rooms)]) if rooms else each.sensor.rig
        camera = rig.camera.model_copy(update={"pattern_seed": sensor.rig.camera.pattern_seed + turn})
        found.append(
            Rendering(
                sensor=each.sensor.model_copy(update={"rig": rig.model_copy(update={"camera": camera})}),
                drawn=each.drawn | {"camera.pattern_seed": float(camera.pattern_seed)},
            )
        )
    return found


def rows_of_renderings(found: list[Rendering]) -> dict[str, float]:
    """What renderings have of their own, as columns of a table: `renderings.0.camera.full_well_e` and so on."""
    return {f"renderings.{turn}.{name}": value for turn, each in enumerate(found) for name, value in each.drawn.items()}


def _drawn(sensor: SweptSensor, sweep: SweepConfig) -> list[Rendering]:
    """Prints and cameras of the renderings."""
    count = sweep.quality.renderings
    if not sweep.draws:
        return [Rendering(sensor=sensor, drawn={})] * count
    recipe = Recipe(
        schema_version=1,
        design=sensor.design,
        rig=sensor.rig,
        seed=sweep.seed,
        episodes=count,
        episodes_per_sensor=1,
        tolerances=sweep.tolerances,
        camera=sweep.camera,
        paths=(ClearPath(kind="clear"),),
    )
    shape = {"unevenness": sensor.design.unevenness}  # a recipe's next unit has another
    return [
        Rendering(
            sensor=sensor.model_copy(
                update={"design": each.scene.design.model_copy(update=shape), "rig": each.scene.rig}
            ),
            drawn=each.values,
        )
        for each in draw_episodes(recipe)
    ]
