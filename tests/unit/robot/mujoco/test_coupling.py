"""Contact of a MuJoCo body with a sensor: rest, momentum, energy; and what is refused."""

from typing import Any

import numpy as np
import pytest
from laboratory.interrupts import differences

from magicsim.errors import ConfigError
from magicsim.geometry.pose import Pose
from magicsim.robot.mujoco import Coupling, Touch, compiled
from magicsim.scenes.scene import SceneConfig, load_scene
from robot.conftest import TINY

from .conftest import BLOCK
from .models import body, mujoco

TOUCH = Touch(site="sensor", body="thing", x_mm=(-3, 3), y_mm=(-3, 3))
RADIUS_MM, MASS_KG = 6.0, 0.05
BALL = f"<geom type='sphere' size='{RADIUS_MM / 1000}' mass='{MASS_KG}'/>"
FLYING = f"""<mujoco><option timestep="0.0005" gravity="0 0 0"/><worldbody>
  <body name="finger"><freejoint/><site name="sensor" pos="0 0 .003" quat="0 1 0 0"/>
    <geom type="box" size=".006 .008 .003" mass="0.1"/></body>
  <body name="thing" pos="0.0005 0 0.0092"><freejoint/>{BALL}</body></worldbody></mujoco>"""


def coupled(spec: Any, scene: SceneConfig, **options: Any) -> Coupling:
    model = compiled(spec, [TOUCH])
    return Coupling(model, mujoco.MjData(model), [TOUCH], scene=scene, **options)


def momentum(coupling: Coupling) -> np.ndarray:
    """Linear [kg m/s] and angular about the common centre of mass [kg m2/s], shape (6,)."""
    model, data = coupling.model, coupling.data
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    return np.concatenate([model.body_subtreemass[0] * data.subtree_linvel[0], data.subtree_angmom[0]])


def kinetic_energy(coupling: Coupling) -> float:
    model, data = coupling.model, coupling.data
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return float(data.qvel @ full @ data.qvel / 2)


def test_ball_comes_to_rest_where_the_force_is_its_weight(block: SceneConfig):
    coupling = coupled(body(BALL), block, damping_s=0.02)
    coupling.data.qpos[2] = (RADIUS_MM - 0.25) / 1000
    while coupling.data.time < 0.15:
        coupling.step()
    weight = MASS_KG * 9.81
    assert coupling.wrench("sensor")[2] == pytest.approx(weight, rel=0.01)
    sensor = coupling.sensors["sensor"]
    sensor.solve(sensor.pose(coupling.data))
    assert sensor.deformation.force_n[2] == pytest.approx(weight, rel=0.03)
    assert abs(coupling.data.qvel[2]) < 1e-3
    assert sensor.solves < 40
    assert coupling.data.xfrc_applied.any() == np.False_


def test_touch_beside_the_crown_of_a_dome_is_met_when_it_begins():
    radius, aside = 12.0, 4.0
    dome = load_scene("grip", [*BLOCK, f'design.face={{kind="dome",radius_x_mm={radius},crown_mm=1.5}}'])
    sensor = coupled(body(BALL), dome).sensors["sensor"]
    touch = radius - np.sqrt((radius + RADIUS_MM) ** 2 - aside**2)  # where the centres are both radii apart
    for height in np.arange(-RADIUS_MM - 0.1, touch + 0.06, 0.01):
        pose = Pose(position_mm=np.array([aside, 0.0, height]), rotation=np.eye(3))
        if sensor.needs_solve(pose):
            sensor.solve(pose)
    assert sensor.wrench(pose)[2] > 0


def test_lattice_is_fine_where_the_touch_says_and_coarser_beyond():
    wide = load_scene("grip", [*BLOCK, "design.footprint_mm=[24,32]"])
    sensor = coupled(body(BALL), wide).sensors["sensor"].sensor
    x = np.unique(sensor.lattice.nodes_mm[:, 0].round(6))
    within, beyond = (np.diff(x[side]).max() for side in (np.abs(x) <= TOUCH.x_mm[1], x >= 0))
    assert beyond > 1.3 * within
    assert len(sensor.lattice.nodes_mm) < len(sensor.printed.nodes_mm)


@pytest.mark.parametrize(("damping_s", "kept"), [(0.0, (0.97, 1.03)), (0.005, (0.05, 0.8))])
def test_collision_keeps_momentum_and_only_damping_takes_energy(
    block: SceneConfig, damping_s: float, kept: tuple[float, float]
):
    coupling = coupled(mujoco.MjSpec.from_string(FLYING), block, damping_s=damping_s)
    coupling.data.qvel[6:9] = (0.0, 0.0, -0.1)
    before, energy = momentum(coupling), kinetic_energy(coupling)
    for _ in range(80):
        coupling.step()
    after = momentum(coupling)
    sensor = coupling.sensors["sensor"]
    assert sensor.solves >= 3
    assert coupling.data.qvel[8] - coupling.data.qvel[2] > 0.01  # they part
    np.testing.assert_allclose(after[:3], before[:3], atol=1e-12)
    np.testing.assert_allclose(after[3:], before[3:], atol=1e-9)
    assert kept[0] < kinetic_energy(coupling) / energy < kept[1]


def test_caller_keeps_its_own_forces_and_a_pushed_ball_presses_harder(block: SceneConfig):
    coupling = coupled(body(BALL), block, damping_s=0.02)
    coupling.data.qpos[2] = (RADIUS_MM - 0.4) / 1000
    coupling.data.xfrc_applied[2, 2] = -0.5
    while coupling.data.time < 0.1:
        coupling.step()
    assert coupling.data.xfrc_applied[2, 2] == -0.5
    assert coupling.wrench("sensor")[2] == pytest.approx(MASS_KG * 9.81 + 0.5, rel=0.02)


def test_frames_come_at_the_camera_s_rate_with_their_truth():
    scene = load_scene("pressed", [*TINY, "rig.room='dark'"])
    spec = body("<geom type='sphere' size='.004' mass='.02' rgba='1 .5 .1 1'/>")
    coupling = coupled(spec, scene, damping_s=0.02)
    coupling.data.qpos[2] = 0.0045
    frames, times = [], []
    while coupling.data.time < 0.14:
        moments = coupling.step()
        if moments is not None:
            times.append(coupling.truths(moments)["sensor"].time_s)
            frames.append(coupling.develop(moments)["sensor"])
    assert times == pytest.approx([0, 1 / 15, 2 / 15], abs=1e-3)
    assert [frame.truth.contact for frame in frames] == [False, True, True]
    assert frames[0].truth.state.gap_mm == pytest.approx(0.5)
    assert frames[0].image.shape == (32, 24, 3)
    assert np.abs(frames[1].image.astype(int) - frames[0].image).mean() > 1


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"damping_s": -1}, "damping_s = -1 is not allowed"),
        ({"tolerance_n": 0}, "tolerance_n = 0 is not allowed"),
        ({"quality": "best"}, "unknown quality 'best'"),
    ],
)
def test_impossible_options_are_refused(block: SceneConfig, options: dict[str, Any], told: str):
    with pytest.raises(ConfigError, match=told):
        coupled(body(BALL), block, **options)


def test_integrator_that_asks_several_times_a_step_is_refused(block: SceneConfig):
    with pytest.raises(ConfigError, match="integrator = RK4 is not allowed"):
        coupled(body(BALL, option="integrator='RK4'"), block)


def test_time_step_too_long_for_a_light_ball_is_refused(block: SceneConfig):
    spec = body("<geom type='sphere' size='.006' mass='.0005'/>")
    spec.option.timestep = 0.005
    coupling = coupled(spec, block)
    coupling.data.qpos[2] = (RADIUS_MM - 0.5) / 1000
    with pytest.raises(ConfigError, match=r"timestep = 0\.005 s is too long for a contact .*: must be below 0\.0"):
        coupling.step()


def test_no_sensor_and_the_same_sensor_twice_are_refused(block: SceneConfig):
    model = compiled(body(BALL), [TOUCH])
    for touches, told in (([], "touches is empty"), ([TOUCH, TOUCH], "the same site twice")):
        with pytest.raises(ConfigError, match=told):
            Coupling(model, mujoco.MjData(model), touches, scene=block)


def test_scene_that_depends_on_time_is_refused():
    scene = load_scene("grip", ["design=mini-magictac-rate", "contact.rate_dependent=true"])
    with pytest.raises(ConfigError, match=r"contact\.rate_dependent = True is not allowed"):
        coupled(body(BALL), scene)


@pytest.mark.parametrize("most", [1, pytest.param(None, marks=pytest.mark.slow)])
def test_step_that_is_interrupted_has_not_happened(block: SceneConfig, most: int | None):
    coupling = coupled(body(BALL), block)

    def begin() -> bytes:
        mujoco.mj_resetData(coupling.model, coupling.data)
        coupling.data.qpos[2] = (RADIUS_MM - 0.3) / 1000
        coupling.reset()
        return b""

    def step() -> bytes:
        moments = coupling.step()
        found = (coupling.data.qpos, coupling.data.qvel, coupling.data.xfrc_applied, coupling.wrench("sensor"))
        return b"".join(each.tobytes() for each in found) + repr(moments is None).encode()

    assert differences({"begins": begin, "first": step, "second": step, "third": step}, most=most, within="robot") == []
