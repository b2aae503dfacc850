"""Light of the room alone, with an object before it: against path tracing, and calm from place to place."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor

pytestmark = [
    pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA"), pytest.mark.usefixtures("untouched_once"),
]  # fmt: skip
SMALL = (
    "rig.strips=[]", "design.footprint_mm=[12,14]", "rig.camera.field_mm=10", "rig.camera.columns=24",
    "rig.camera.rows=28", "rig.camera.blur_px=0", "object.radius_mm=4",
)  # fmt: skip
QUICK = ("render.anchor_particles=40000", "render.anchor_samples=32")
PLACE = {"x_mm": 1.0, "y_mm": 0.5, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}


def state(gap_mm):
    return FrameState(gap_mm=gap_mm, **PLACE)


def sensor_of(*overrides, gap_mm=1.0, seed=1):
    press = f"keyframes=[{{frame=0,gap_mm={gap_mm},x_mm=1.0,y_mm=0.5}}]"
    return Sensor.for_scene(load_scene("near", [*SMALL, press, *overrides], seed=seed))


def means(gap_mm, seeds, *overrides, plain=False):
    """Mean radiance of each channel and its standard error."""
    found = []
    for seed in seeds:
        sensor = sensor_of(*overrides, f"render.anchor_seed={seed}", gap_mm=gap_mm, seed=seed)
        deformation = sensor.deform(state(gap_mm), sensor.rest) if gap_mm < 0 else sensor.rest
        view = sensor.view(state(gap_mm), deformation)
        image = sensor.renderer.plain_radiance(view) if plain else sensor.renderer.radiance(view)
        found.append(image.mean((0, 1), dtype=np.float64))
    return np.mean(found, 0), np.std(found, 0, ddof=1) / np.sqrt(len(found))


@pytest.mark.parametrize(
    "gap_mm", [2.0, pytest.param(20.0, marks=pytest.mark.slow), pytest.param(-0.6, marks=pytest.mark.slow)]
)
def test_an_object_before_a_lit_room_is_as_bright_as_by_path_tracing(gap_mm):
    # Pressed, the estimator is asked without its anchor: what an anchored frame shows of a touch's light is less than
    # all of it, and under this ball, in a room that alone gives light, 2 % too bright (docs/physics/light.md).
    path, path_error = means(gap_mm, range(100, 103), "render.estimator=path", "render.samples=128", plain=True)
    unanchored = ("render.anchor_samples=0", "render.particles=200000", "render.samples=64")
    few = ("render.anchor_particles=200000",)
    found, error = means(gap_mm, range(3), *(unanchored if gap_mm < 0 else few), plain=gap_mm < 0)
    noise = np.hypot(error / found, path_error / path)
    assert noise.max() < 0.015, "too noisy to tell anything"
    assert (np.abs(found / path - 1) < 0.01 + 3 * noise).all(), f"{found / path}, standard error {noise}"


def test_light_hardly_jumps_between_neighbouring_places():
    """Random numbers are those of a frame's seed wherever the object is: what it does not meet stays as it is."""

    def jumps(seeds):
        sensors, images = {seed: sensor_of(*QUICK, seed=seed) for seed in set(seeds)}, []
        for gap_mm, seed in zip((1.0, 1.02, 1.04), seeds, strict=True):
            images.append(sensors[seed].radiance(state(gap_mm), sensors[seed].rest))
        blocks = np.array([image.reshape(4, 7, 4, 6, 3).mean((1, 3)) for image in images], np.float64)
        return float((blocks[0] - 2 * blocks[1] + blocks[2]).std() / blocks.mean())

    assert jumps((1, 1, 1)) < 0.3 * jumps((1, 2, 3))


@pytest.mark.parametrize(
    "light",
    [
        "ring={radiance=[30,30,30],radius_mm=18}",
        "leds=[{place_mm=[-16,0,3],direction=[1,0,0.3],radiance=[300,300,300]}]",
    ],
)
def test_lights_beside_the_opening_of_the_housing_shine_in_a_lit_room_as_in_a_dark_one(light):
    """Rendering is linear: what the room adds to a lamp's image is what it shows alone."""
    block = (
        "rig=digit-rgb", *SMALL, "design.cell_mm=0", "object.color=[0.9,0.9,0.9]",
        "rig.lens.thickness_mm=1", "render.anchor_samples=0", "render.samples=256", "render.particles=200000",
    )  # fmt: skip
    ambient = "rig.ambient=[0.05,0.05,0.05]"

    def image(*more):
        sensor = sensor_of(*block, *more)
        return sensor.renderer.plain_radiance(sensor.view(state(1.0), sensor.rest)).mean((0, 1), dtype=np.float64)

    lamp, room, both = image(f"rig.{light}"), image(ambient), image(f"rig.{light}", ambient)
    assert lamp.min() > 0.2 * room.max()
    assert both == pytest.approx(lamp + room, rel=0.02)
