"""A light that is off is a scene like any other: it sends out nothing, and the light of the others stays as it was."""

import logging

import numpy as np
import pytest

from magicsim.light.variant import SCALAR_VARIANT, activate_variant
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.simulation.stream import simulate

SMALL = [
    "rig=digit-rgb",
    "design.footprint_mm=[6,6]", "design.core_mm=2.0", "rig.camera.columns=12", "rig.camera.rows=12",
    "rig.camera.field_mm=5.0", "render.samples=4", "render.particles=2000", "render.anchor_samples=4",
    "render.anchor_particles=2000", "references=1", "object.radius_mm=2.0", "design.lattice.spacing_mm=1.0",
    "design.lattice.cells_across=0", "output.report=false", "output.preview=false",
]  # fmt: skip
NEAR, TOUCHED, LIT = "{frame=0, gap_mm=1.0}", "{frame=1, gap_mm=-0.2}", "{frame=2, flashlight=true}"
DARK = "[0,0,0]"

pytestmark = pytest.mark.skipif(activate_variant() == SCALAR_VARIANT, reason="needs LLVM or CUDA")


def scene(*overrides: str, keyframes: tuple[str, ...] = (NEAR, TOUCHED, LIT)) -> SceneConfig:
    return load_scene("near", [*SMALL, f"keyframes=[{', '.join(keyframes)}]", *overrides], seed=3)


def strips(left: str, right: str) -> str:
    return f"rig.strips=[{{side='-x', radiance={left}}}, {{side='+x', radiance={right}}}]"


def radiance(config: SceneConfig) -> np.ndarray:
    from magicsim.scenes.timeline import timeline
    from magicsim.simulation.sensor import Sensor

    sensor = Sensor.for_scene(config)
    return sensor.renderer.plain_radiance(sensor.view(timeline(config)[0], sensor.rest))


@pytest.mark.parametrize("estimator", ["fluence", "path"])
def test_images_of_one_strip_on_and_the_other_off_add_up_to_the_image_of_both(estimator: str):
    left, right, both = (
        radiance(scene(strips(*pair), f"render.estimator={estimator}", keyframes=(NEAR,)))
        for pair in (("[5,1,0]", DARK), (DARK, "[0,2,5]"), ("[5,1,0]", "[0,2,5]"))
    )
    assert left.max() > 0
    assert right.max() > 0
    np.testing.assert_allclose(left + right, both, rtol=2e-3, atol=1e-5 * both.max())


@pytest.mark.parametrize(
    "settings",
    [
        pytest.param(("rig.strips=[]",), marks=pytest.mark.slow),
        (strips(DARK, DARK),),
        (strips(DARK, DARK), "render.estimator=path"),
        pytest.param(("rig.strips=[]", "design.cell_mm=0"), marks=pytest.mark.slow),
    ],
)
def test_sensor_without_light_gives_black_frames_and_one_warning(
    settings: tuple[str, ...], caplog: pytest.LogCaptureFixture
):
    caplog.set_level(logging.WARNING)
    episode = simulate(scene(*settings, "rig.flashlight.radiance=[0,0,0]"))
    assert [frame.image.mean() < 1 for frame in episode.frames] == [True] * 4
    assert [record.message for record in caplog.records] == [
        "frame 0 is black (mean grey level 0): no light of rig.strips, rig.leds and rig.ring shines, "
        "and the room is dark (rig.ambient, rig.room)"
    ]


def test_flashlight_alone_lights_a_sensor_whose_strips_are_off():
    episode = simulate(scene("rig.strips=[]"))
    assert [frame.image.mean() > 1 for frame in episode.frames] == [False, False, False, True]


def test_glossy_object_before_a_black_gel_is_black_and_told(caplog: pytest.LogCaptureFixture):
    caplog.set_level(logging.WARNING)
    episode = simulate(scene("design.materials.body.absorption_per_mm=100", "object.specular=0.5", keyframes=(NEAR,)))
    assert max(frame.image.mean() for frame in episode.frames) < 1
    assert "absorption_per_mm" in caplog.text


def test_one_red_strip_is_exposed_and_leaves_the_other_channels_dark():
    episode = simulate(scene(strips("[5,0,0]", DARK), keyframes=("{frame=0}",)))
    red, green, blue = episode.frames[0].image.mean((0, 1))
    assert red == pytest.approx(90, abs=2)
    assert max(green, blue) < 1


def test_basis_has_a_black_image_for_a_light_that_is_off():
    from magicsim.scenes.timeline import View
    from magicsim.simulation.sensor import Sensor

    basis = Sensor.for_scene(scene(strips("[5,5,5]", DARK), keyframes=("{frame=0}",))).renderer.basis(View())
    assert basis["strip0"].max() > 0
    assert basis["strip1"].max() == 0


def test_live_sensor_without_light_is_black_until_the_flashlight_is_on():
    from magicsim.robot.live import LiveSensor

    with LiveSensor(scene("rig.strips=[]")) as live:
        assert live.frame().image.mean() < 1
        live.shine()
        assert live.frame().image.mean() > 1
