"""Nothing in a frame tells that the object touches but what the touch does: noise and mean are continuous there."""

from functools import cache

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from magicsim.light.backend import VARIANT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import ALONE, UNTOUCHED, FrameState
from magicsim.simulation.sensor import Sensor

pytestmark = [
    pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA"), pytest.mark.usefixtures("untouched_once"),
]  # fmt: skip
SMALL = (
    "design.footprint_mm=[16,20]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=48", "rig.camera.rows=60",
    "rig.camera.field_mm=14", "render.samples=4", "render.particles=8000", "render.anchor_samples=16",
    "render.anchor_particles=100000",
)  # fmt: skip
QUICK = (
    "design.footprint_mm=[12,14]", "design.lattice.cells_across=0", "rig.camera.field_mm=11",
    "rig.camera.columns=24", "rig.camera.rows=28", "render.anchor_particles=30000",
)  # fmt: skip
"""Where no noise is asked for."""
PLACE = {"x_mm": 5.0, "y_mm": 6.0, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}
CORNERS = [(rows, columns) for rows in (slice(0, 24), slice(36, 60)) for columns in (slice(0, 16), slice(32, 48))]
NEAR_CORNER = CORNERS[1]
"""That of the contact."""
CAMERA_NOISE = 0.25
"""Of the default camera [grey levels]."""
TOUCHES_MM = (-0.005, -0.02, -0.05)
HIDDEN = 0.001
"""A third of the noise of rounding to grey levels, 0.29 of a level, in units of the brightness, 90 levels."""


def state(gap_mm, *, flashlight=False):
    return FrameState(**(PLACE | {"gap_mm": gap_mm, "flashlight": flashlight}))


@cache
def sensor_of(*settings, seed=1, gap_mm=-0.05):
    press = f"keyframes=[{{frame=0,gap_mm={gap_mm},x_mm={PLACE['x_mm']},y_mm={PLACE['y_mm']}}}]"
    return Sensor.for_scene(load_scene("pressed", [*SMALL, "object.radius_mm=2.5", press, *settings], seed=seed))


def seen(sensor, each):
    deformation = sensor.deform(each, sensor.rest) if each.can_touch else sensor.rest
    return sensor.radiance(each, deformation).astype(np.float64)


def far_noise(sensor, gaps_mm):
    """Of what frames add to the untouched one, in the corner that is the furthest from the contact, over brightness."""
    untouched, levels = seen(sensor, UNTOUCHED), []
    for gap_mm in gaps_mm:
        change = seen(sensor, state(gap_mm)) - untouched
        around = sum(np.roll(change, step, axis) for step in (-1, 1) for axis in (0, 1)) / 4
        levels.append(min(float((change - around)[corner].std()) for corner in CORNERS))
    return np.sqrt(np.mean(np.square(levels))) / untouched.mean()


GLOSSY = ("object.specular=0.3", "object.roughness=0.4")


@pytest.mark.parametrize("settings", [(), pytest.param(GLOSSY, marks=pytest.mark.slow)])
def test_noise_far_away_does_not_tell_a_light_touch(settings):
    sensor = sensor_of(*settings)
    assert far_noise(sensor, (0.02, 0.005)) < HIDDEN
    assert far_noise(sensor, TOUCHES_MM) < HIDDEN


@pytest.mark.slow
def test_without_the_bound_the_noise_would_tell():
    """What the test above does not see is there to be seen."""
    dark = "rig=digit-rgb"
    assert far_noise(sensor_of(dark, "render.still_mm=0", "render.reuse_mm=0"), TOUCHES_MM) > 3 * far_noise(
        sensor_of(dark), TOUCHES_MM
    )


def test_every_frame_says_how_it_was_made():
    quick = (*QUICK, "rig=digit-rgb", "render.anchor_samples=2", "render.anchor_particles=4000")
    sensor, touch = sensor_of(*quick), state(-0.05)

    def way(each):
        deformation = sensor.deform(each, sensor.rest) if each.can_touch else sensor.rest
        found = sensor.render(each, deformation)[1]
        return found.light, found.image

    assert way(UNTOUCHED) == ("untouched", "untouched")
    assert way(state(1900.0)) == ("untouched", "untouched")  # too far to be seen
    assert way(state(0.003)) == ("outside", "recorded")
    assert way(touch) == ("before contact", "traced")
    alone = sensor_of(*QUICK, "render.anchor_samples=0")
    assert alone.render(UNTOUCHED, alone.rest)[1] == ALONE


@pytest.mark.parametrize("flashlight", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_mean_is_continuous_at_contact(flashlight):
    changes = []
    for seed in (1, 2):
        sensor = sensor_of(*QUICK, seed=seed)
        before, after = (seen(sensor, state(gap, flashlight=flashlight)).mean((0, 1)) for gap in (0.003, -0.005))
        changes.append(after / before - 1)
    assert np.abs(np.mean(changes, 0)).max() < 0.01
    assert np.std(changes, axis=0).max() < 0.01


def test_grain_far_from_a_deep_touch_is_below_the_cameras_noise():
    """Of the error of the change, what a mean over a few pixels takes off: 1.0 before noise was told from change.

    With twice the default samples. With the default eight it is 0.25 to 0.29 here (twelve seeds, three lattices), no
    less than the camera's own.
    """
    deep, deepest = state(-0.6), {"gap_mm": -0.6}
    careful = sensor_of("render.samples=32", "render.particles=20000", "render.anchor_samples=0", **deepest)
    deformation = careful.deform(deep, careful.rest)
    touched, untouched = careful.view(deep, deformation), careful.view(UNTOUCHED, careful.rest)

    def grain(change):
        return (change - gaussian_filter(change, (1, 1, 0)))[far]

    far = np.zeros((60, 48), bool)
    for corner in CORNERS:
        far[corner] = corner != NEAR_CORNER
    truth = []
    for turn in range(1, 5):  # their noise is independent, and adds nothing to the mean of products
        now, before = (careful.renderer.plain_radiance(view, turn=turn) for view in (touched, untouched))
        truth.append(grain(now.astype(np.float64) - before))
    squares = []
    for seed in (1, 2):
        sensor = sensor_of("render.samples=16", "render.anchor_samples=64", seed=seed, **deepest)
        rest = seen(sensor, UNTOUCHED)
        error = grain(sensor.radiance(deep, deformation).astype(np.float64) - rest) - truth
        products = error.sum(0) ** 2 - (error**2).sum(0)
        squares.append(products.mean() / (len(truth) * (len(truth) - 1)) / rest.mean() ** 2)
    assert np.mean(squares) < (CAMERA_NOISE / 90) ** 2
