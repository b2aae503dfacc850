"""Light is linear: one image for each light adds up to all of them, and to other strengths."""

import numpy as np
import pytest

from magicsim.light.relight import relight
from magicsim.light.variant import SCALAR_VARIANT, activate_variant
from magicsim.scenes.scene import load_scene

SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[6,6]", "design.core_mm=2.0", "rig.camera.columns=12", "rig.camera.rows=12",
    "rig.camera.field_mm=5.0", "render.samples=8", "render.particles=4000",
]  # fmt: skip


def images(estimator: str, *overrides: str):
    from magicsim.light.renderer import Renderer
    from magicsim.scenes.timeline import View
    from magicsim.simulation.sensor import Sensor

    scene = load_scene("rest", [*SMALL, f"render.estimator={estimator}", *overrides], seed=3)
    renderer: Renderer = Sensor.for_scene(scene).renderer
    return renderer.basis(View()), renderer.plain_radiance(View())


@pytest.mark.parametrize("estimator", ["fluence", "path"])
def test_basis_images_add_up_to_the_image(estimator: str) -> None:
    if estimator == "fluence" and activate_variant() == SCALAR_VARIANT:
        pytest.skip("needs LLVM or CUDA")
    basis, whole = images(estimator)
    assert len(basis) == 4
    assert all(image.max() > 0 for image in basis.values())
    np.testing.assert_allclose(sum(basis.values()), whole, rtol=2e-3, atol=1e-5 * whole.max())


def test_a_dimmed_strip_is_a_weighted_sum() -> None:
    if activate_variant() == SCALAR_VARIANT:
        pytest.skip("needs LLVM or CUDA")
    from magicsim.scenes.timeline import View
    from magicsim.simulation.sensor import Sensor

    scene = load_scene("rest", SMALL, seed=3)
    dimmed = scene.rig.strips[0].model_copy(update={"radiance": tuple(0.25 * c for c in scene.rig.strips[0].radiance)})
    rig = scene.rig.model_copy(update={"strips": (dimmed, *scene.rig.strips[1:])})
    basis, _ = images("fluence")
    name = next(iter(basis))
    rendered = Sensor.for_scene(scene.model_copy(update={"rig": rig})).renderer.plain_radiance(View())
    np.testing.assert_allclose(relight(basis, {name: 0.25}), rendered, rtol=2e-3, atol=1e-5 * rendered.max())
