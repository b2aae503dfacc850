"""Sensors of a model that look at each other."""

from dataclasses import replace
from typing import Any

import pytest

from magicsim.errors import ConfigError
from magicsim.robot.mujoco import Coupling, Touch, compiled
from magicsim.scenes.scene import SceneConfig, load_scene
from robot.conftest import TINY

from .models import mujoco

FINGERS = """<mujoco><option timestep="{dt}" gravity="0 0 0"/><worldbody>
  <body name="left" pos="-.01 0 0"><joint name="left" type="slide" axis="1 0 0"/>
    <site name="left" xyaxes="0 -1 0 0 0 1"/><geom type="box" size=".003 .008 .008" pos="-.004 0 0" mass="0.1"/></body>
  <body name="right" pos=".01 {aside} 0"><site name="right" {axes}/>
    <geom type="box" size=".003 .008 .008" pos=".004 0 0" mass="0.1"/></body>
  <body name="ball"><freejoint/><geom type="sphere" size=".004" mass="0.01"/></body></worldbody></mujoco>"""
LEFT = Touch(site="left", body="ball", faces="right", x_mm=(-3, 3), y_mm=(-3, 3))
RIGHT = Touch(site="right", body="ball", faces="left", x_mm=(-3, 3), y_mm=(-3, 3))


def coupled(scene: SceneConfig, touches: tuple[Touch, ...] = (LEFT, RIGHT), **model: Any) -> Coupling:
    values = {"dt": 0.001, "aside": 0.0, "axes": 'xyaxes="0 1 0 0 0 1"'} | model
    compiled_model = compiled(mujoco.MjSpec.from_string(FINGERS.format(**values)), touches)
    return Coupling(compiled_model, mujoco.MjData(compiled_model), touches, scene=scene)


def test_each_sensor_is_told_how_far_away_the_other_one_is(block: SceneConfig):
    coupling = coupled(block, (LEFT, replace(RIGHT, faces=None)))
    coupling.data.qpos[0] = 0.002
    moments = coupling.step()
    assert moments is not None
    assert moments["left"].state.facing_mm == pytest.approx(18.0)
    assert moments["right"].state.facing_mm is None


def test_facing_sensor_brings_light(block: SceneConfig):
    del block
    scene = load_scene("pressed", TINY)
    images = []
    for touches in ((LEFT, RIGHT), tuple(replace(each, faces=None) for each in (LEFT, RIGHT))):
        coupling = coupled(scene, touches)
        images.append(coupling.develop({"left": coupling.step()["left"]})["left"].image)
    assert images[0].mean() > images[1].mean() + 2


@pytest.mark.parametrize(
    ("model", "told"),
    [
        (
            {"aside": 0.003},
            r"site 'left' does not face site 'right' at 0\.000 s: 0 degrees .*, 3 mm aside, 20 mm",
        ),
        ({"axes": 'xyaxes="0 -1 0 0 0 1"'}, "180 degrees from half a turn about y"),
    ],
)
def test_sensors_that_look_elsewhere_are_refused(block: SceneConfig, model: dict[str, Any], told: str):
    coupling = coupled(block, **model)
    with pytest.raises(ConfigError, match=told):
        coupling.step()


def test_names_and_rates_that_do_not_fit_are_refused(block: SceneConfig):
    with pytest.raises(ConfigError, match=r"unknown faces 'write' \(did you mean 'right'\?\)"):
        coupled(block, (replace(LEFT, faces="write"), RIGHT))
    with pytest.raises(ConfigError, match="unknown faces 'left'"):
        coupled(block, (replace(LEFT, faces="left"), RIGHT))
    with pytest.raises(ConfigError, match=r"timestep = 0\.1 s is not allowed: must be at most 0\.06667 s"):
        coupled(block, dt=0.1)
    faster = block.model_copy(update={"frames_per_second": 30.0})
    with pytest.raises(ConfigError, match="frames_per_second = 30 of site 'right' is not allowed: must be 15"):
        coupled(block, (LEFT, replace(RIGHT, scene=faster)))
