"""Renderings of the press with chosen constants, and those that the model is made from."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import qmc

from laboratory.real_frames.constants import GAPS_MM, LOGARITHMS, RANGES, Constants
from laboratory.real_frames.frames import COLUMNS, FOLDER, ROWS, profile
from magicsim.arrays import Array
from magicsim.config.models import validate
from magicsim.fit.constants import CONSTANTS, with_values
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor

POINTS, SEED = 20, 3
SKETCH = ("render.samples=64", "render.particles=2000000")
CAREFUL = ("render.samples=256", "render.particles=4000000")
SHOWN = ("render.samples=1024", "render.particles=4000000")
"""Quality of renderings that are fitted, of predictions, and of what is shown: SSIM takes grain for structure."""
TURNS = 2


def press_scene(gaps_mm: Sequence[float], *overrides: str) -> SceneConfig:
    """The press at some depths, one keyframe each, so that all are on one lattice."""
    camera = (f"rig.camera.columns={COLUMNS}", f"rig.camera.rows={ROWS}", "rig.camera.blur_px=0")
    data = load_scene(FOLDER / "9dtact.toml", [*camera, *overrides]).model_dump(mode="json")
    (first,) = data["keyframes"]
    data["keyframes"] = [{**first, "frame": number, "gap_mm": gap} for number, gap in enumerate(gaps_mm)]
    return validate(SceneConfig, data, source="the real press")


def solved(scene: SceneConfig) -> list[Any]:
    """Equilibria of a scene's keyframes."""
    sensor = Sensor.for_scene(scene)
    found = [sensor.rest]
    for state in sensor.states:
        found.append(sensor.deform(state, found[-1]))
    return found


def images(scene: SceneConfig, solution: list[Any], rendered: Array, *, turns: int = 1) -> Array:
    """Radiance, untouched and in each state, shape (states + 1, 69, 92)."""
    values = [*np.exp(rendered[:LOGARITHMS]), *rendered[LOGARITHMS:]]
    paths = [CONSTANTS[name].path for name in RANGES]
    sensor = Sensor.for_scene(with_values(scene, dict(zip(paths, map(float, values), strict=True))))
    views = [sensor.view(state, each) for state, each in zip((UNTOUCHED, *sensor.states), solution, strict=True)]
    return np.array(
        [
            np.mean([sensor.renderer.plain_radiance(view, turn=turn).mean(2) for turn in range(turns)], 0)
            for view in views
        ],
        np.float64,
    )


def radiance(constants: Constants, *overrides: str, turns: int = TURNS) -> Array:
    """Whole frames, untouched and pressed, rendered with some constants, shape (2, 69, 92).

    Args:
        constants: Of sensor and press.
        overrides: Of the scene.
        turns: Renderings whose mean is taken.
    """
    scene = press_scene((-constants.depth_mm,), *overrides)
    return images(scene, solved(scene), constants.rendered, turns=turns)


def places() -> Array:
    """Rendered constants of the Latin hypercube, shape (points, 4)."""
    low, high = np.array(list(RANGES.values())).T
    return np.asarray(qmc.scale(qmc.LatinHypercube(len(RANGES), rng=SEED).random(POINTS), low, high))


def render(some: Sequence[int]) -> list[list[list[float]]]:
    """Rings of radiance at some places, untouched and at every depth; shape (places, 5, rings)."""
    scene = press_scene(GAPS_MM, *SKETCH)
    solution, points, found = solved(scene), places(), []
    for number in some:
        found.append([profile(each).round(6).tolist() for each in images(scene, solution, points[number])])
        print("rendered", number, flush=True)
    return found
