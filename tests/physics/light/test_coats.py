"""Coats, half mirrors, markers and domes: against Mitsuba's path tracer, and in balance."""

import numpy as np
import pytest

from magicsim.scenes.timeline import View
from magicsim.simulation.sensor import Sensor, sensor_exposure

BLOCK = (
    "design.footprint_mm=[8,9]", "rig.camera.field_mm=7", "design.skin_mm=0.5", "design.core_mm=3",
    "design.cell_mm=0", "rig.ambient=[0.3,0.2,0.1]", "render.samples=16",
)  # fmt: skip
COAT = ('design.coat={kind="opaque",color=[0.6,0.5,0.4],specular=0.2,roughness=0.3}',)
FILM = ('design.coat={kind="half_mirror",reflectance=0.5,transmittance=0.3}',)
DOTS = (
    'design.markers={kind="dots",pitch_mm=2,diameter_mm=1,color=[0.1,0.1,0.1],pattern="random",seed=3}',
    *FILM,
)
BELOW = ('design.markers={kind="dots",pitch_mm=2,diameter_mm=1,color=[0.1,0.1,0.1],depth_mm=0.5}',)
DOME = ('design.face={kind="dome",radius_x_mm=8.0,radius_y_mm=12.0,crown_mm=0.9,rim_mm=0.2}',)
CASES = {"coat": COAT, "film": FILM, "dots": DOTS, "below": BELOW, "dome": DOME, "coated dome": DOME + COAT}
IN_OTHERS = ("coat", "film", "dome")
"""Cases that are parts of `dots` and `coated dome`."""


def images(scene, seeds):
    sensor, found = Sensor.for_scene(scene), []
    for seed in seeds:
        sensor.renderer.seed = seed
        found.append(sensor.renderer.plain_radiance(View()))
    return np.array(found, np.float64)


@pytest.mark.parametrize(
    "case", [pytest.param(each, marks=pytest.mark.slow if each in IN_OTHERS else ()) for each in CASES]
)
def test_fluence_agrees_with_path_tracing(case, small_scene):
    ours = images(small_scene("rest", *BLOCK, *CASES[case]), range(3))
    path = images(
        small_scene("rest", *BLOCK, *CASES[case], "render.estimator=path", "render.samples=48"), range(100, 103)
    )
    means = [each.mean((1, 2)) for each in (ours, path)]
    noise = np.hypot(*(each.std(0, ddof=1) / np.sqrt(3) / each.mean(0) for each in means))
    difference = np.abs(means[0].mean(0) / means[1].mean(0) - 1)
    assert (difference < 0.005 + 3 * noise).all()
    assert noise.max() < 0.03
    blocks = [each.mean(0).reshape(8, 8, 6, 8, 3).mean((1, 3)) for each in (ours, path)]
    assert np.abs(blocks[0] - blocks[1]).mean() < 0.03 * blocks[1].mean()


@pytest.mark.parametrize("case", ["dots", "coated dome"])
def test_emitted_light_is_absorbed_or_escapes(case, small_scene):
    light = Sensor.for_scene(small_scene("rest", *BLOCK, *CASES[case])).renderer.light(View())
    for name in ("strip0", "strip2"):
        account = light.balance(name, particles=20_000, seed=5)
        assert account["absorbed"] + account["escaped"] == pytest.approx(account["emitted"], rel=0.005)
    if "coat" in case:
        assert account["absorbed"] > 0.5 * account["emitted"]


def test_a_red_strip_under_an_opaque_coat_is_exposed_whatever_the_room(small_scene):
    red = small_scene("rest", *BLOCK, *COAT, "rig.strips=[{side='-x',radiance=[5,0,0]}]")
    sensor = Sensor.for_scene(red)
    gain = sensor_exposure(sensor, sensor.renderer.radiance(View()))
    assert np.isfinite(gain).all()
    assert red.lit == sensor.lit == (True, False, False)
