"""A touch that can change little of the light in the block is shown in the light of just before it."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor

pytestmark = [
    pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA"), pytest.mark.usefixtures("untouched_once"),
]  # fmt: skip
CHEAP = (
    "render.samples=2", "render.particles=2000", "render.anchor_samples=4", "render.anchor_particles=4000",
    "design.lattice.spacing_mm=2",
)  # fmt: skip
CALM = (*CHEAP, "render.anchor_particles=40000")
MANY = (
    *CHEAP, "render.samples=4", "render.particles=30000", "render.anchor_samples=4", "render.anchor_particles=30000",
)  # fmt: skip
COVERED = ("object={kind='box',size_mm=[14,17,10]}", "keyframes=[{frame=0,gap_mm=-0.1}]")
TRACED, LEFT_OUT = "render.light_change=0", "render.light_change=1"


def made(scene):
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    return sensor.render(state, sensor.deform(state, sensor.rest))


def image(scene):
    return made(scene)[0].astype(np.float64)


def light_touch(depth_mm):
    return f"keyframes=[{{frame=0,gap_mm=-{depth_mm}}}]"


@pytest.fixture(scope="module")
def left_out(small_scene):
    """Image of a light touch on a small clear block, and how it was made."""
    return made(small_scene("pressed", *CHEAP, light_touch(0.05)))


def test_how_much_of_the_face_is_covered_decides_and_frames_say_so(small_scene, left_out):
    traced = made(small_scene("pressed", *CHEAP, light_touch(0.05), TRACED))
    covered = made(small_scene("pressed", *CHEAP, *COVERED))
    assert [way.light for _, way in (left_out, traced, covered)] == ["before contact", "traced", "traced"]
    assert not np.array_equal(left_out[0], traced[0])


def test_a_scattering_body_is_always_traced(small_scene, left_out):
    hazy = made(small_scene("pressed", *CHEAP, light_touch(0.05), "design.materials.body.sigma_s_per_mm=0.3"))
    assert (hazy[1].light, left_out[1].light) == ("traced", "before contact")


@pytest.mark.parametrize("depth_mm", [0.1, pytest.param(0.5, marks=pytest.mark.slow)])
def test_mean_brightness_is_that_of_traced_light_within_the_bound(whole_block, depth_mm):
    traced, left_out = (
        image(whole_block("pressed", *MANY, light_touch(depth_mm), more)) for more in (TRACED, LEFT_OUT)
    )
    np.testing.assert_allclose(left_out.mean((0, 1)), traced.mean((0, 1)), rtol=0.01)


def test_light_has_no_step_at_contact_under_a_flashlight_in_a_room(whole_block):
    """The lamp hides a part of the room, before contact as in it."""
    states = [f"keyframes=[{{frame=0,gap_mm={gap},x_mm=-6,y_mm=-9,flashlight=true}}]" for gap in (0.002, -0.002)]
    lit = (*CALM, "rig.room=office", "rig.ambient=[0.3,0.3,0.3]")
    near, touched = (image(whole_block("pressed", *lit, state)) for state in states)
    rows, columns = (size // 4 for size in near.shape[:2])
    change = (touched - near) / near.mean()
    corners = [change[:rows, :columns], change[:rows, -columns:], change[-rows:, -columns:]]
    assert max(abs(each.mean()) for each in corners) < 3e-4


def test_a_renderer_that_nobody_holds_goes_at_once(small_scene):
    """Its records are hundreds of megabytes, and the next sensor does not wait for the collector of circles."""
    scene = small_scene("pressed", *CHEAP, light_touch(0.05))
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    sensor.radiance(state, sensor.deform(state, sensor.rest))
    kept = weakref.ref(sensor.renderer)
    gc.disable()
    try:
        del sensor
        assert kept() is None
    finally:
        gc.enable()


def test_a_dent_that_stays_looks_the_same_whatever_was_shown_before(small_scene):
    hazy = ("design.materials.body.sigma_s_per_mm=0.3", light_touch(0.3))
    scene = small_scene("pressed", *CHEAP, *hazy)
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    dent = replace(sensor.view(state, sensor.deform(state, sensor.rest)), indenter=None, is_released=True)
    first, second = (sensor.renderer.radiance(dent) for _ in range(2))
    assert np.array_equal(first, second)
