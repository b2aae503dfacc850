"""One object held by two fingers: balance of forces and torques, symmetry, and Coulomb's bound on what is held."""

from collections.abc import Iterator

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import parse_object
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.held import BALANCE_SHARE
from magicsim.robot.grip.linkage import Linkage
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import load_scene

FRICTION = 0.8
BLOCK = (
    "design=uniform-block", "design.footprint_mm=[12,16]", "design.lattice.spacing_mm=2",
    "design.lattice.cells_across=0", "rig.camera.columns=24", "rig.camera.rows=32", f"contact.friction={FRICTION}",
)  # fmt: skip
SPACE = Workspace(
    x_mm=(-3, 3), y_mm=(-4, 4), twist_deg=(-60, 60), tilt_x_deg=(-15, 15), tilt_y_deg=(-15, 15), gap_mm=(-1.2, 5)
)
PLATE = parse_object("box:size_mm=5x7x8,edge_radius_mm=0.5")


@pytest.fixture(scope="module")
def shared() -> Iterator[Gripper]:
    scene = load_scene("grip", BLOCK).model_copy(update={"object": PLATE})
    with Gripper(scene, workspace=SPACE, sees_other=False) as gripper:
        yield gripper


@pytest.fixture
def gripper(shared: Gripper) -> Gripper:
    """Two fingers that press a plate 0.2 mm deep from both sides."""
    shared.reset()
    shared.close(shared.touching_width_mm - 0.4)
    return shared


def normal_n(gripper: Gripper) -> float:
    return gripper.truth().upper.force_n[2]


def test_held_object_is_in_balance_with_weight_and_outer_wrench_in_any_direction(gripper: Gripper):
    pressed = normal_n(gripper)
    load = Load(
        weight_n=0.4 * pressed, down=(1, -2, 1), centre_mm=(0.3, 0.2, 0), force_n=(0.1, 0, 0), torque_nmm=(1, -1, 2)
    )
    assert gripper.hold(load=load) is Hold.HELD
    truth = gripper.truth()
    tolerance = BALANCE_SHARE * max(truth.upper.force_n[2], truth.lower.force_n[2])
    down = np.array([1, -2, 1]) / np.sqrt(6)
    outer = 0.4 * pressed * down + [0.1, 0, 0]
    np.testing.assert_allclose(np.add(truth.force_n, outer), 0, atol=1.5 * tolerance)
    torque = np.cross([0.3, 0.2, 0], 0.4 * pressed * down) + np.array([1, -1, 2])  # tilts are small
    np.testing.assert_allclose(np.add(truth.torque_nmm, torque), 0, atol=4 * tolerance + 0.05)
    assert truth.place.y_mm < 0 < truth.place.x_mm  # it gives way along the load
    assert truth.place.z_mm > 0
    assert truth.upper.force_n[2] > truth.lower.force_n[2]  # gravity presses it into the upper finger
    for finger in (truth.upper, truth.lower):  # what the object does to the skin, the base bears
        assert finger.solve.force_balance < 0.02


def test_symmetric_load_gives_both_fingers_the_same(gripper: Gripper):
    assert gripper.hold(load=Load(weight_n=0.8 * normal_n(gripper))) is Hold.HELD
    truth = gripper.truth()
    upper, lower = (np.array(finger.force_n) for finger in (truth.upper, truth.lower))
    np.testing.assert_allclose(upper, lower, atol=1e-3 * upper[2])
    assert truth.place.x_mm == pytest.approx(0, abs=1e-3)
    assert truth.place.z_mm == pytest.approx(0, abs=1e-3)
    assert abs(truth.place.twist_deg) < 0.01


def test_weight_is_held_up_to_the_bound_of_friction_and_dropped_beyond(gripper: Gripper):
    pressed = normal_n(gripper)
    assert gripper.hold(load=Load(weight_n=1.4 * pressed)) in {Hold.HELD, Hold.SLIPPED}
    truth = gripper.truth()
    assert truth.force_n[1] == pytest.approx(1.4 * pressed, rel=0.02)
    assert truth.force_n[1] <= 2 * FRICTION * truth.upper.force_n[2] * 1.02
    assert gripper.upper.slip_share > 0.3
    assert gripper.hold(load=Load(weight_n=1.75 * pressed)) is Hold.DROPPED
    truth = gripper.truth()
    assert not truth.upper.contact
    assert not truth.upper.state.has_object
    assert truth.force_n == (0, 0, 0)
    with pytest.raises(ConfigError, match="the object has dropped"):
        gripper.hold()
    gripper.close(gripper.width_mm, place=ObjectPlace())
    assert gripper.truth().hold is Hold.PLACED


def test_fingers_that_open_let_the_object_go(gripper: Gripper):
    assert gripper.hold(load=Load(weight_n=0.2)) is Hold.HELD
    assert gripper.hold(gripper.touching_width_mm + 0.1) is Hold.DROPPED


def test_torque_about_the_line_of_both_contacts_turns_the_object_until_friction_bears_it(gripper: Gripper):
    assert gripper.hold(load=Load(torque_nmm=(0, 0, 2.0))) is Hold.HELD
    truth = gripper.truth()
    assert truth.torque_nmm[2] == pytest.approx(-2.0, rel=0.05)
    assert 0.1 < truth.place.twist_deg < 30


def test_cranks_close_at_their_speed_along_their_arc_and_stall_at_their_force(gripper: Gripper):
    gripper.linkage = Linkage(speed_deg_s=10, force_limit_n=3.0)
    try:
        gripper.close(gripper.touching_width_mm + 0.5, place=ObjectPlace())
        start, along = gripper.angle_deg, gripper.linkage.along_mm(gripper.angle_deg)
        gripper.turn_to(-3, dt_s=0.02)
        assert gripper.angle_deg == pytest.approx(start - 0.2)
        rise = gripper.linkage.along_mm(gripper.angle_deg) - along
        assert gripper.place.y_mm == pytest.approx(-rise)  # the object stays in the room, the tips pass it
        gripper.turn_to(-3, dt_s=0.02, load=None)
        gripper.turn_to(-3, dt_s=0.04)
        truth = gripper.truth()
        assert truth.is_stalled
        assert truth.upper.force_n[2] == pytest.approx(3.0, rel=0.01)
    finally:
        gripper.linkage = Linkage()


def test_motors_stall_on_the_object_and_not_before_it_however_far_away_they_begin(gripper: Gripper):
    gripper.linkage = Linkage(speed_deg_s=1000, force_limit_n=3.0)
    try:
        gripper.close(gripper.touching_width_mm + 9, place=ObjectPlace())
        gripper.turn_to(-4, dt_s=1)  # told to go deeper than the workspace
        truth = gripper.truth()
        assert truth.is_stalled
        assert truth.upper.force_n[2] == pytest.approx(3.0, rel=0.01)
        gripper.close(gripper.touching_width_mm + 9, place=ObjectPlace(z_mm=0.4))
        gripper.turn_to(-4, dt_s=1)  # the upper finger alone has met it
        truth = gripper.truth()
        assert truth.is_stalled
        assert (truth.upper.force_n[2], truth.lower.force_n[2]) == pytest.approx((3.0, 0.0), rel=0.01)
        gripper.close(gripper.touching_width_mm + 9, place=ObjectPlace(z_mm=0.4))
        gripper.turn_to(-4, dt_s=1, floats=True)
        truth = gripper.truth()
        assert truth.is_stalled
        assert (truth.upper.force_n[2], truth.lower.force_n[2]) == pytest.approx((3.0, 3.0), rel=0.015)
    finally:
        gripper.linkage = Linkage()


def test_motors_that_are_stronger_than_the_workspace_is_deep_are_refused_and_nothing_moves(gripper: Gripper):
    gripper.linkage = Linkage(speed_deg_s=1000, force_limit_n=900.0)
    try:
        before = gripper.width_mm
        with pytest.raises(ConfigError, match="gap_mm"):
            gripper.turn_to(gripper.linkage.angle_deg(gripper.touching_width_mm - 2.6), dt_s=1)
        assert gripper.width_mm == before
    finally:
        gripper.linkage = Linkage()


def test_object_that_is_turned_to_the_end_of_the_workspace_is_dropped_there_by_name(gripper: Gripper):
    assert gripper.hold(load=Load(torque_nmm=(0, 60.0, 0))) is Hold.DROPPED
    truth = gripper.truth()
    assert truth.limit == "tilt_y_deg"
    assert truth.place.tilt_y_deg == pytest.approx(SPACE.tilt_y_deg[1], abs=0.5)


def test_weight_of_a_light_object_counts_however_hard_it_is_pressed(gripper: Gripper):
    weight = 0.03 * normal_n(gripper)
    assert gripper.hold(load=Load(weight_n=weight, centre_mm=(2.0, 0, 0))) is Hold.HELD
    truth = gripper.truth()
    assert truth.force_n[1] == pytest.approx(weight, rel=0.1)
    assert truth.torque_nmm[2] == pytest.approx(2.0 * weight, rel=0.25)


def test_impossible_distances_are_refused_in_one_line(gripper: Gripper):
    with pytest.raises(ConfigError, match="width_mm = -1 is not allowed: the fingers would pass through each other"):
        gripper.close(-1)
    with pytest.raises(ConfigError, match=r"width_mm = 4 is not allowed: the object does not fit, 8 mm between the"):
        gripper.hold(4)
    scene = load_scene("grip", BLOCK).model_copy(update={"object": parse_object("box:size_mm=5x7x120")})
    with pytest.raises(ConfigError, match=r"object 'box' does not fit between the fingers: 120 mm along"):
        Gripper(scene, workspace=SPACE)
