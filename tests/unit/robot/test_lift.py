from collections.abc import Iterator

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.held import BALANCE_SHARE
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.lift import Lift
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import load_scene

from .conftest import BLOCK

SPACE = Workspace(
    x_mm=(-2, 2), y_mm=(-5, 2), twist_deg=(-25, 25), tilt_x_deg=(-10, 10), tilt_y_deg=(-10, 10), gap_mm=(-1.5, 6)
)
FRICTION = 0.8


@pytest.fixture(scope="module")
def shared() -> Iterator[Gripper]:
    with Gripper(load_scene("grip", BLOCK), workspace=SPACE, sees_other=False) as gripper:
        yield gripper


@pytest.fixture
def gripper(shared: Gripper) -> Gripper:
    """Two fingers with friction 0.8 and a ball between them, solved and not rendered."""
    shared.reset()
    return shared


def gripped(gripper: Gripper, load: Load, depth_mm: float = 0.5, place: ObjectPlace | None = None) -> Lift:
    """A closed grip on an object that stands on the table."""
    place = place or ObjectPlace()
    lift = Lift(gripper, load=load, width_mm=gripper.touching_width_mm + 0.2, place=place)
    lift.step(closing_mm=0.1 + depth_mm, rising_mm=0)
    return lift


def test_object_light_enough_hangs_with_friction_equal_to_its_weight(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=1.0))
    assert lift.state.hold is Hold.PLACED
    assert 2 * FRICTION * lift.state.normal_n > 2
    for _ in range(2):
        before, state = lift.state, lift.step(closing_mm=0, rising_mm=0.3)
    assert 0.3 < state.object_mm < 0.6
    assert state.carried_n == pytest.approx(1.0, abs=1.5 * BALANCE_SHARE * state.normal_n)
    assert state.slip_share < 0.5
    assert state.hold in {Hold.HELD, Hold.SLIPPED}
    assert state.object_mm - before.object_mm == pytest.approx(0.3, abs=0.02)  # no more stretch, no slip


@pytest.mark.slow
def test_object_too_heavy_stays_and_slips_at_the_limit_of_friction(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=8.0))
    for _ in range(4):
        state = lift.step(closing_mm=0, rising_mm=0.4)
    assert (state.object_mm, state.hold) == (0, Hold.PLACED)
    assert state.slip_share > 0.99
    assert state.carried_n == pytest.approx(2 * FRICTION * state.normal_n, rel=0.15)  # the ball's face is not level
    assert state.slip_mm == pytest.approx(0.4, rel=0.2)


def test_object_slides_back_to_the_table_when_the_grip_loosens(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=1.0))
    for _ in range(2):
        high = lift.step(closing_mm=0, rising_mm=0.3)
    loose = lift.step(closing_mm=-0.4, rising_mm=0)
    assert 2 * FRICTION * loose.normal_n < 1.0 < high.carried_n + 0.1
    assert (loose.object_mm, loose.hold, loose.has_dropped) == (0, Hold.DROPPED, True)
    after = lift.step(closing_mm=0, rising_mm=0)
    assert (after.object_mm, after.hold) == (0, Hold.PLACED)


def test_released_object_falls_to_the_table_and_can_be_taken_again(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=1.0))
    lift.step(closing_mm=0, rising_mm=0.5)
    landed = lift.step(closing_mm=-1, rising_mm=0)
    assert (landed.object_mm, landed.carried_n, landed.hold) == (0, 0, Hold.DROPPED)
    assert gripper.place.y_mm == pytest.approx(-0.5)
    lift.step(closing_mm=1, rising_mm=0)
    assert lift.step(closing_mm=0, rising_mm=0.4).object_mm > 0


def test_object_that_is_lowered_is_on_the_table_and_was_not_dropped(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=1.0))
    lift.step(closing_mm=0, rising_mm=0.5)
    down = lift.step(closing_mm=0, rising_mm=-0.5)
    assert (down.object_mm, down.hold) == (0, Hold.PLACED)


def test_object_stays_on_the_table_while_fingers_move_around_it(gripper: Gripper):
    width = gripper.touching_width_mm + 2
    lift = Lift(gripper, load=Load(weight_n=1.0), width_mm=width, place=ObjectPlace(y_mm=0.5, z_mm=0.3))
    state = lift.step(closing_mm=0.5, rising_mm=2)
    assert (state.object_mm, state.carried_n, state.width_mm) == (0, 0, width - 1)
    assert gripper.place == ObjectPlace(y_mm=0.5 - 2, z_mm=0.3)


def test_finger_that_touches_first_pushes_the_object_and_both_press_alike(gripper: Gripper):
    width = gripper.touching_width_mm + 1
    lift = Lift(gripper, load=Load(weight_n=1.0), width_mm=width, place=ObjectPlace(z_mm=0.4))
    lift.step(closing_mm=0.3, rising_mm=0)
    assert gripper.place.z_mm == pytest.approx(0.2)
    lift.step(closing_mm=0.5, rising_mm=0)
    truth = gripper.truth()
    assert truth.upper.force_n[2] == pytest.approx(truth.lower.force_n[2], abs=0.01)


def test_sideways_force_moves_the_object_once_the_table_lets_go(gripper: Gripper):
    lift = gripped(gripper, Load(weight_n=0.6, force_n=(0.8, 0, 0)))
    assert gripper.place.x_mm == 0
    lift.step(closing_mm=0, rising_mm=0.4)
    truth = gripper.truth()
    np.testing.assert_allclose(truth.force_n, [-0.8, 0.6, 0], atol=0.05)
    assert gripper.place.x_mm > 0.02


def test_step_out_of_the_workspace_changes_nothing(gripper: Gripper):
    lift = Lift(gripper, load=Load(weight_n=1.0), width_mm=gripper.touching_width_mm + 2, place=ObjectPlace())
    before, place = lift.state, gripper.place
    with pytest.raises(ConfigError, match="y_mm = -6 is not allowed"):
        lift.step(closing_mm=0, rising_mm=6)
    assert lift.state is before
    assert gripper.place == place
