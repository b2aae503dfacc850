"""What stands outside may be traced in a scene of its own, or, as on an NVIDIA GPU, in one with the block."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT
from magicsim.light.variant import CUDA_VARIANT
from magicsim.scenes.scene import load_scene
from magicsim.simulation.sensor import Sensor

pytestmark = pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
SMALL = [
    "rig=digit-office", "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "rig.camera.columns=24",
    "rig.camera.rows=28", "object.radius_mm=3", "render.particles=4000", "render.anchor_particles=20000",
    "render.anchor_samples=8", "design.lattice.spacing_mm=2", "design.lattice.cells_across=0",
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "more"), [pytest.param("pressed", (), marks=pytest.mark.slow), ("near", ("object.specular=0.5",))]
)
def test_one_scene_with_the_block_gives_the_frames_of_two(name, more, monkeypatch):
    def frame():
        sensor = Sensor.for_scene(load_scene(name, [*SMALL, *more]))
        state = sensor.states[0]
        return sensor.radiance(state, sensor.deform(state, sensor.rest))

    two = frame()
    monkeypatch.setattr("magicsim.light.world.loaded_scene.VARIANT", CUDA_VARIANT)
    one = frame()
    # Searches that round otherwise send single paths elsewhere.
    assert np.abs(one - two).mean() < 1e-4 * two.mean()
    np.testing.assert_allclose(one.mean((0, 1)), two.mean((0, 1)), rtol=1e-4)
