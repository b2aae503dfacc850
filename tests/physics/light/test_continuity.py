"""Nothing in a frame tells that the object touches but what the touch does: noise and mean are continuous there."""

import numpy as np
import pytest

from magicsim.plan import can_touch
from magicsim.scenes.backend import VARIANT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState
from magicsim.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT != "llvm_ad_rgb", reason="needs LLVM")
SMALL = (
    "design.footprint_mm=[16,20]", "design.lattice.spacing_mm=1.2", "rig.camera.columns=48", "rig.camera.rows=60",
    "rig.camera.field_mm=14", "render.samples=4", "render.particles=8000", "render.anchor_samples=16",
    "render.anchor_particles=100000",
)  # fmt: skip
PLACE = {"x_mm": 5.0, "y_mm": 6.0, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}
FAR = (
    (slice(0, 24), slice(0, 16)),
    (slice(36, 60), slice(0, 16)),
    (slice(36, 60), slice(32, 48)),
    (slice(0, 24), slice(32, 48)),
)


def state(gap_mm, *, flashlight=False):
    return FrameState(**(PLACE | {"gap_mm": gap_mm, "flashlight": flashlight}))


def sensor_of(*settings, seed=1):
    press = f"keyframes=[{{frame=0,gap_mm=-0.05,x_mm={PLACE['x_mm']},y_mm={PLACE['y_mm']}}}]"
    return Sensor(load_scene("pressed", [*SMALL, "object.radius_mm=2.5", press, *settings], seed=seed))


def seen(sensor, each):
    deformation = sensor.deform(each, sensor.rest) if can_touch(each) else sensor.rest
    return sensor.radiance(each, deformation).astype(np.float64)


def far_noise(change):
    """Of the quarter of the image that is the furthest from the contact, whichever that is in the picture."""
    around = sum(np.roll(change, step, axis) for step in (-1, 1) for axis in (0, 1)) / 4
    return min(float((change - around)[block].std()) for block in FAR)


@pytest.mark.parametrize("settings", [(), ("object.specular=0.3", "object.roughness=0.4"), ("contact.coupling='dry'",)])
def test_noise_far_away_does_not_tell_a_light_touch(settings):
    sensor = sensor_of(*settings)
    untouched = seen(sensor, UNTOUCHED)
    before = [far_noise(seen(sensor, state(gap)) - untouched) for gap in (0.02, 0.005)]
    after = [far_noise(seen(sensor, state(gap)) - untouched) for gap in (-0.005, -0.02, -0.05)]
    assert max(after) < 1.5 * max(before)
    assert min(after) > 0.5 * min(before)


def test_without_the_bound_the_noise_would_tell():
    """What the test above sees is there to be seen."""
    sensor = sensor_of("render.still_mm=0")
    untouched = seen(sensor, UNTOUCHED)
    before = far_noise(seen(sensor, state(0.005)) - untouched)
    assert far_noise(seen(sensor, state(-0.05)) - untouched) > 3 * before


@pytest.mark.parametrize("flashlight", [False, True])
def test_mean_is_continuous_at_contact(flashlight):
    changes = []
    for seed in (1, 2, 3):
        sensor = sensor_of(seed=seed)
        before, after = (seen(sensor, state(gap, flashlight=flashlight)).mean((0, 1)) for gap in (0.003, -0.005))
        changes.append(after / before - 1)
    assert np.abs(np.mean(changes, 0)).max() < 0.01
    assert np.std(changes, axis=0).max() < 0.01
