"""Energy balance of the light pass: what the lights emit is absorbed or escapes, at rest and deformed."""

import pytest

from magicsim.scenes.timeline import View, timeline
from magicsim.simulation.sensor import Sensor

SMALL = ("design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "object.radius_mm=3")


@pytest.mark.parametrize(
    ("state", "overrides"),
    [
        pytest.param("near", (), marks=pytest.mark.slow),
        ("pressed", ("object.specular=0.5",)),
        ("pressed", ("design.materials.body.sigma_s_per_mm=0.3", "design.materials.infill.sigma_s_per_mm=2")),
    ],
)
def test_emitted_light_is_absorbed_or_escapes(state, overrides, small_scene):
    scene = small_scene(state, *SMALL, *overrides)
    sensor = Sensor.for_scene(scene)
    frame = timeline(scene)[0]
    view = sensor.view(frame, sensor.deform(frame, sensor.rest) if frame.can_touch else sensor.rest)
    light = sensor.renderer.light(view)
    for name in light.lights:
        account = light.balance(name, particles=15_000, seed=5)
        assert account["absorbed"] > 0
        assert account["escaped"] > 0
        assert account["absorbed"] + account["escaped"] == pytest.approx(account["emitted"], rel=0.005)
        assert abs(account["ended"]) < 0.005 * account["emitted"]


def test_light_of_a_faint_small_led_is_that_of_a_bright_one(small_scene):
    def fluence(radiance):
        led = f"rig.leds=[{{place_mm=[-8,0,3],direction=[1,0,0],radius_mm=0.05,radiance={[radiance] * 3}}}]"
        sensor = Sensor.for_scene(small_scene("near", *SMALL, "rig.strips=[]", led))
        light = sensor.renderer.light(View())
        return light.light_fields({"led0": 20_000}, seed=1)["led0"].fluence.sum() / radiance

    assert fluence(1e-5) == pytest.approx(fluence(1000.0), rel=1e-3)
