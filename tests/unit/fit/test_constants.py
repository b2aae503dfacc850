import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.fit.constants import CONSTANTS, constants_named, fitted_scene, value_of, with_values
from magicsim.scenes.scene import load_scene


@pytest.mark.parametrize("name", CONSTANTS)
def test_default_sensor_lies_in_every_assumed_range(name: str):
    each = CONSTANTS[name]
    special = name.startswith(("gel", "coat", "press", "ring"))
    pressed = ["keyframes=[{frame=0,gap_mm=-1.9}]"] if special else []
    scene = load_scene("translucent-9dtact" if special else "rest", pressed)
    share = each.share(value_of(scene, each.path))
    assert 0 <= share <= 1
    assert each.at(share) == pytest.approx(value_of(scene, each.path))


def test_value_outside_its_range_is_refused():
    with pytest.raises(
        ConfigError, match=r"design\.wall_mm = 0\.5 is not allowed: must be in its assumed range, 0\.1 to"
    ):
        CONSTANTS["wall"].share(0.5)


def test_star_reaches_every_strip():
    scene = with_values(load_scene("rest"), {"rig.strips.*.margin_mm": 1.5})
    assert [each.margin_mm for each in scene.rig.strips] == [1.5] * 4
    assert value_of(scene, "rig.strips.*.margin_mm") == 1.5


@pytest.mark.parametrize("path", ["rig.strip.margin_mm", "design.materials.skin.ior"])
def test_field_that_does_not_exist_is_named(path: str):
    with pytest.raises(ConfigError, match=path.rpartition(".")[0].split(".")[-1]):
        with_values(load_scene("rest"), {path: 1.0})


def test_unknown_or_repeated_constant_is_refused():
    with pytest.raises(ConfigError, match=r"unknown constant 'gama' \(did you mean 'gamma'\?\)"):
        constants_named(["gama"])
    with pytest.raises(ConfigError, match="'gamma' is given twice"):
        constants_named(["gamma", "gamma"])


def test_fitted_strengths_of_ring_and_leds_are_those_of_the_scene():
    scene = load_scene(
        "translucent-9dtact", ["rig.leds=[{place_mm=[9.0,0.0,12.0],direction=[0.0,0.0,-1.0],radiance=[1.0,1.0,1.0]}]"]
    )
    assert scene.rig.ring is not None
    strengths = {("ring", channel): (2.0, 1.0, 0.5)[channel] for channel in range(3)}
    strengths |= {("led0", channel): 3.0 for channel in range(3)}
    found = fitted_scene(scene, {}, strengths, np.full((4, 3, 3), 90.0)).rig
    ring, led = (np.array(each.radiance) for each in (found.ring, found.leds[0]))
    before = np.array(scene.rig.ring.radiance)
    np.testing.assert_allclose((ring / before) / (ring / before)[1], [2, 1, 0.5])
    np.testing.assert_allclose(led / (ring / before)[1], 3.0)
