import pytest

from magicsim.light.records.untouched import KEPT, Untouched, UntouchedStates, untouched_key
from magicsim.scenes.scene import load_scene


def key(*settings: str) -> str:
    scene = load_scene("rest", settings)
    return untouched_key(scene.design, scene.rig, scene.render)


@pytest.mark.parametrize(
    "setting",
    [
        "design.skin_mm=0.7", "design.materials.infill.ior=1.47", "rig.camera.columns=100", "rig.camera.vignetting=0.2",
        "rig.lens.thickness_mm=1.0", "rig.camera.distance_mm=20.0", "rig.camera.distortion=[0.1,0.0,0.0,0.0,0.0]",
        "rig.camera.principal_offset_px=[1.0,0.0]", "rig.camera.field_mm=20.0", "rig.camera.rows=100",
        "render.anchor_samples=3", "render.anchor_particles=1000", "render.anchor_seed=2",
        "rig.ambient=[0.1,0.0,0.0]", "render.forward_collisions=2",
        "rig.strips=[{side='-x',radiance=[1.0,0.0,0.0]}]",
    ],
)  # fmt: skip
def test_whatever_changes_the_radiance_of_the_untouched_sensor_changes_its_key(setting: str):
    assert key(setting) != key()


@pytest.mark.parametrize(
    "setting",
    ["rig.camera.exposure_grey=50.0", "rig.camera.read_noise_e=9.0", "rig.camera.pattern_seed=3", "render.samples=2",
     "render.particles=500", "rig.flashlight.radius_mm=3.0", "seed=9"],
)  # fmt: skip
def test_what_comes_after_the_radiance_does_not(setting: str):
    assert key(setting) == key()


def test_state_that_was_not_asked_for_the_longest_goes_first():
    states = UntouchedStates()
    state = Untouched(fields={}, particles={}, paths=None, light=None, held_mm3=None, image=None)
    for number in range(2 * KEPT):
        states.keep(str(number), state)
    assert states.get("0") is state
    states.keep("new", state)
    assert states.get("0") is state
    assert states.get("1") is None
    assert states.get("new") is state
