"""Frames by one kind of processor beside those by another."""

import numpy as np
import pytest
from processors import difference, main

from magicsim.light.backend import VARIANT

SMALL = [
    "rig.camera.columns=16", "rig.camera.rows=12", "design.lattice.spacing_mm=2", "render.samples=1",
    "render.particles=2000", "render.anchor_samples=2", "render.anchor_particles=4000",
]  # fmt: skip


def test_difference_is_that_of_means_and_of_pixels():
    other = np.full((2, 2, 3), 2.0, np.float32)
    one = other + np.float32([0.2, 0, 0]) * np.float32([[[1], [1]], [[1], [1]]])
    found = difference(one, other)
    np.testing.assert_allclose(found["means"], [0.1, 0, 0], atol=1e-5)
    np.testing.assert_allclose(found["rms"], 0.2 / 3**0.5 / 2, atol=1e-5)


@pytest.mark.slow
@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_frames_of_the_saved_states_are_compared(tmp_path):
    main("save", tmp_path / "states", SMALL, 1)
    found = main("compare", tmp_path / "states", SMALL, 1)
    assert {each["kind"] for each in found["states"]} == {"near", "touching", "flashlight"}
    assert max(each["rms"] for each in found["states"]) < (1e-6 if VARIANT == "llvm_ad_rgb" else 0.02)
