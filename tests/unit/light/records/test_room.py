"""The room's part of the untouched image, by recorded paths, is what the image loses in the dark."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, View
from magicsim.simulation.sensor import Sensor, room_radiance

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = (
    "rig=digit-office", "rig.ambient=[0.1,0.1,0.1]", "design.footprint_mm=[10,12]", "rig.camera.field_mm=9",
    "rig.camera.columns=36", "rig.camera.rows=44", "rig.camera.flicker={mains_hz=50}",
    "render.anchor_samples=64", "render.anchor_particles=100000",
)  # fmt: skip


def test_room_s_part_is_what_the_dark_lacks():
    sensor = Sensor.for_scene(load_scene("pressed", SMALL, seed=1))
    untouched = sensor.radiance(UNTOUCHED, sensor.rest)
    dark = sensor.with_rig(sensor.rig.model_copy(update={"ambient": (0.0, 0.0, 0.0)}))
    lacks = untouched - dark.renderer.radiance(View())
    found = room_radiance(sensor, untouched)
    assert lacks.mean() > 0.05 * untouched.mean()
    np.testing.assert_allclose(found.mean((0, 1)), lacks.mean((0, 1)), rtol=0.03)
    blocks = [each.reshape(11, 4, 9, 4, 3).mean((1, 3)) for each in (found, lacks)]
    assert np.sqrt(np.mean((blocks[0] - blocks[1]) ** 2)) < 0.1 * np.sqrt(np.mean(blocks[1] ** 2))
    assert found.min() >= 0
    assert (found <= untouched).all()
