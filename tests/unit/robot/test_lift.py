import pytest

from magicsim.errors import ConfigError
from magicsim.robot.lift import BALANCE_SHARE, GRAVITY_MM_S2, Lift
from magicsim.robot.live import LiveSensor

FRAME_S = 1 / 15


def gripped(live: LiveSensor, weight_n: float, depth_mm: float = 0.5) -> Lift:
    """A closed grip on an object that stands on the table."""
    lift = Lift(live, weight_n=weight_n, gap_mm=0.1)
    lift.step(closing_mm=0.1 + depth_mm, rising_mm=0, dt_s=FRAME_S)
    return lift


def test_object_light_enough_hangs_with_friction_equal_to_its_weight(rubbing: LiveSensor):
    lift = gripped(rubbing, 1.0)
    assert 2 * 0.8 * lift.state.normal_n > 2
    for _ in range(2):
        before, state = lift.state, lift.step(closing_mm=0, rising_mm=0.3, dt_s=FRAME_S)
    assert 0.3 < state.object_mm < 0.6
    assert state.carried_n == pytest.approx(1.0, rel=BALANCE_SHARE)
    assert state.slip_share < 0.5
    assert state.object_mm - before.object_mm == pytest.approx(0.3, abs=0.02)  # no more stretch, no slip


@pytest.mark.slow
def test_object_too_heavy_stays_and_slips_at_the_limit_of_friction(rubbing: LiveSensor):
    lift = gripped(rubbing, 8.0)
    for _ in range(4):
        state = lift.step(closing_mm=0, rising_mm=0.4, dt_s=FRAME_S)
    assert state.object_mm == 0
    assert state.slip_share > 0.99
    assert state.carried_n == pytest.approx(2 * 0.8 * state.normal_n, rel=0.15)  # the ball's face is not level
    assert state.slip_mm == pytest.approx(0.4, rel=0.2)
    assert not state.has_dropped


@pytest.mark.slow
def test_grip_that_loosens_lets_the_object_slip_down_until_friction_or_the_table_stops_it(rubbing: LiveSensor):
    lift = gripped(rubbing, 1.0)
    for _ in range(3):
        high = lift.step(closing_mm=0, rising_mm=0.3, dt_s=FRAME_S)
    loose = lift.step(closing_mm=-0.4, rising_mm=0, dt_s=FRAME_S)
    assert 2 * 0.8 * loose.normal_n < 1.0
    assert loose.object_mm < high.object_mm
    assert loose.slip_share == pytest.approx(1)
    assert loose.has_dropped == (loose.object_mm == 0)


def test_released_object_falls_freely(rubbing: LiveSensor):
    lift = gripped(rubbing, 1.0)
    for _ in range(3):
        high = lift.step(closing_mm=0, rising_mm=0.5, dt_s=FRAME_S)
    first = lift.step(closing_mm=-1, rising_mm=0, dt_s=0.01)
    assert high.object_mm - first.object_mm == pytest.approx(GRAVITY_MM_S2 * 0.01**2 / 2)
    assert first.falling_mm_s == pytest.approx(GRAVITY_MM_S2 * 0.01)
    assert first.carried_n == 0
    second = lift.step(closing_mm=0, rising_mm=0, dt_s=0.005)
    assert high.object_mm - second.object_mm == pytest.approx(GRAVITY_MM_S2 * 0.015**2 / 2)
    landed = lift.step(closing_mm=0, rising_mm=0, dt_s=FRAME_S)
    assert (landed.object_mm, landed.falling_mm_s, landed.has_dropped) == (0, 0, True)
    assert not lift.step(closing_mm=0, rising_mm=0, dt_s=FRAME_S).has_dropped


def test_object_stays_on_the_table_while_fingers_move_around_it(rubbing: LiveSensor):
    lift = Lift(rubbing, weight_n=1.0, gap_mm=1.0, y_mm=0.5)
    state = lift.step(closing_mm=0.5, rising_mm=2, dt_s=FRAME_S)
    assert (state.object_mm, state.carried_n, state.gap_mm) == (0, 0, 0.5)
    assert rubbing.state.y_mm == pytest.approx(0.5 - 2)


def test_step_out_of_the_workspace_changes_nothing(rubbing: LiveSensor):
    lift = Lift(rubbing, weight_n=1.0, gap_mm=1.0)
    before, pose = lift.state, rubbing.state
    with pytest.raises(ConfigError, match="y_mm = -5 is not allowed"):
        lift.step(closing_mm=0, rising_mm=5, dt_s=FRAME_S)
    assert lift.state is before
    assert rubbing.state == pose
