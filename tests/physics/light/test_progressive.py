"""A progressive rendering stops where it says that it does, and its error is what it says."""

import numpy as np
import pytest

from magicsim.light.plain_renderer import central
from magicsim.light.variant import SCALAR_VARIANT, activate_variant
from magicsim.scenes.scene import load_scene

SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[6,6]", "design.core_mm=2.0", "rig.camera.columns=24", "rig.camera.rows=24",
    "rig.camera.field_mm=5.0", "render.samples=4", "render.particles=4000", "render.estimator=fluence",
]  # fmt: skip


@pytest.mark.skipif(activate_variant() == SCALAR_VARIANT, reason="needs LLVM or CUDA")
def test_estimated_error_is_the_distance_to_a_converged_image() -> None:
    from magicsim.scenes.timeline import View
    from magicsim.simulation.sensor import Sensor

    renderer = Sensor.for_scene(load_scene("rest", SMALL, seed=3)).renderer
    converged = Sensor.for_scene(load_scene("rest", SMALL, seed=900_000)).renderer.refined(View(), 0.015)
    found = renderer.refined(View(), 0.03)
    assert found.relative_error <= 0.03
    assert found.passes > 4
    error = np.sqrt((central(found.image - converged.image) ** 2).mean()) / central(converged.image).mean()
    expected = np.hypot(found.relative_error, converged.relative_error)
    assert error == pytest.approx(expected, rel=0.25)
