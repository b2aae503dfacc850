"""Models that come with the program know the sensor whose name they have, and keep to their word on a new touch."""

import numpy as np
import pytest

from magicsim.camera.exposure import meter
from magicsim.config.presets import preset_root
from magicsim.dataset.recipes.draw import draw_sensors
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.emulator.emulator import EMULATED
from magicsim.emulator.model import ALL, MODELS, find_model
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

FILES = sorted((preset_root() / MODELS).glob("*.touch"))
MOST_BYTES = 10_000_000


def test_the_default_sensor_has_a_model():
    assert load_scene("pressed").design == load_scene("pressed", ["design=mini-magictac"]).design
    assert "mini-magictac" in [path.stem for path in FILES]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_model_is_found_for_its_design_and_says_how_far_off_it_is(path):
    scene = load_scene("pressed", [f"design={path.stem}", "render.tier=fast"])
    model, reason = find_model(None, scene.design, scene.rig)
    assert model is not None, reason
    assert model.facts.name == path.stem
    assert path.stat().st_size <= MOST_BYTES
    (whole,) = (row for row in model.facts.errors if row.states == ALL)
    assert whole.error < 0.75 * whole.change
    assert whole.touches >= 30


@pytest.mark.parametrize("name", ["default", "touches"])
def test_units_of_the_recipes_that_come_with_the_program_are_known(name):
    recipe = load_recipe(name, ["episodes=20", "episodes_per_sensor=1"])
    reasons = [find_model(None, each.design, each.rig)[1] for each in draw_sensors(recipe, 20)]
    assert reasons == [""] * 20


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_touch_that_no_example_had_is_as_close_as_the_model_says(path):
    settings = [f"design={path.stem}", "object={kind='sphere',radius_mm=4,color=[0.6,0.5,0.4]}"]
    fast, *true = (
        Sensor.for_scene(load_scene("pressed", [*settings, *each], seed=seed))
        for seed, each in ((1, ["render.tier=fast", "render.outside_domain=refuse"]), (2, []), (3, []))
    )
    rest = fast.radiance(UNTOUCHED, fast.rest)
    gain = 255 * meter(rest, fast.rig.camera)
    state = FrameState(gap_mm=-0.6, x_mm=1.3, y_mm=-2.1, twist_deg=0, flashlight=False, light_x_mm=0)
    deformation = fast.deform(state, fast.rest)
    image, origin = fast.render(state, deformation)
    assert origin == EMULATED
    first, second = (gain * (each.radiance(state, deformation) - image) for each in true)
    model, _ = find_model(None, fast.design, fast.rig)
    (whole,) = (row for row in model.facts.errors if row.states == ALL)
    assert np.sqrt(max(0, np.mean(first * second))) < 1.5 * whole.error
