"""What is too far to be seen is left out, and the bound that says so holds for what is rendered."""

import numpy as np
import pytest

from magicsim.camera.camera import Camera
from magicsim.camera.exposure import meter
from magicsim.light.backend import VARIANT
from magicsim.light.reach import FAINT_LEVELS, brightest_return, grey_levels, is_out_of_reach
from magicsim.light.world.finish import Finish
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, timeline
from magicsim.simulation.sensor import Sensor

SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24", "rig.camera.rows=28",
    "object.radius_mm=30", "object.color=[1,1,1]", "render.samples=4", "render.particles=20000",
    "render.anchor_samples=16", "render.anchor_particles=100000",
]  # fmt: skip
GREY = np.full((4, 4, 3), 0.3, np.float32)


def far(gap_mm, *settings):
    return load_scene("near", [*SMALL, f"keyframes=[{{frame=0, gap_mm={gap_mm}}}]", *settings])


def test_return_falls_with_the_square_of_the_distance_and_follows_lights_and_reflectance():
    scene, white = far(1), Finish(color=(1, 1, 1))
    one, two = (brightest_return(gap, white, scene.design, scene.rig) for gap in (1000, 2000))
    assert one / two == pytest.approx(4, rel=0.02)
    radius = (np.linalg.norm([8, 9, scene.design.height_mm + 2]) / 2) + 0.3  # lights behind air
    assert one == pytest.approx(5 * (radius / 1000) ** 2, rel=0.02)
    dim = brightest_return(1000, Finish(color=(0.5, 0.25, 0)), scene.design, scene.rig)
    assert dim == pytest.approx(one * [0.5, 0.25, 0])
    assert np.isinf(brightest_return(1, white, scene.design, scene.rig)).all()


def test_what_stands_beside_a_light_off_the_block_sees_all_of_it():
    white, beside = Finish(color=(1, 1, 1)), "rig.leds=[{place_mm=[%s],direction=[0,0,-1],radiance=[9,9,9]}]"
    below, above, none = (far(1, *more) for more in ([beside % "0,0,-300"], [beside % "0,300,0"], []))
    assert np.isinf(brightest_return(250, white, below.design, below.rig)).all()
    wide, small = (brightest_return(5000, white, each.design, each.rig) for each in (above, none))
    assert wide == pytest.approx(9 * (300 / 5000) ** 2, rel=0.02)
    assert (wide > 100 * small).all()


@pytest.mark.parametrize("gamma", [0.5, 1.0, 2.2])
def test_grey_levels_bound_what_the_tone_curve_makes_of_any_pixel(gamma):
    camera, gain = Camera(gamma=gamma), np.array([1.0, 2.0, 0.5])
    added, before = 0.01, np.linspace(0, 0.97, 200)
    rise = 255 * ((before + 2 * added) ** (1 / gamma) - before ** (1 / gamma))
    bound = grey_levels(np.full(3, added), gain, camera)
    assert rise.max() <= bound * (1 + 1e-9)
    assert bound <= 1.1 * rise.max()


@pytest.mark.parametrize(
    ("finish", "settings", "gone"),
    [
        (Finish(), [], True),
        (Finish(specular=0.1), [], False),
        (Finish(is_ghost=True), [], False),
        (Finish(), ["rig.ambient=[0,0.01,0]"], False),
        (Finish(), ["rig.flashlight.distance_mm=6000"], False),
    ],
)
def test_what_mirrors_hides_the_room_or_stands_before_the_light_is_never_too_far(finish, settings, gone):
    scene = far(1, *settings)
    assert is_out_of_reach(5000, finish, scene.design, scene.rig, GREY) == gone
    assert not is_out_of_reach(50, finish, scene.design, scene.rig, GREY)


@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_a_far_object_is_left_out_and_what_it_would_have_changed_is_within_the_bound():
    scene = far(2000)
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    rest = sensor.radiance(UNTOUCHED, sensor.rest)
    assert (sensor.radiance(state, sensor.rest) == rest).all()

    near = far(60)
    sensor, state = Sensor.for_scene(near), timeline(near)[0]
    exposure = meter(rest, near.rig.camera)
    change = np.abs(sensor.radiance(state, sensor.rest) - rest).max((0, 1))
    bound = brightest_return(60, sensor.renderer.object_finish, near.design, near.rig)
    assert (change > 0).all()
    assert (change < bound).all()
    assert grey_levels(bound, exposure, near.rig.camera) > FAINT_LEVELS
