import math

import pytest

from magicsim_experiments.task.alignment.episode import down_at, line_angle_deg, turned_deg

CONTROL = {"dt_s": 0.1, "gain_per_s": 4.0, "most_deg_s": 60.0}


def test_wrist_turns_against_what_is_read_no_faster_than_it_can():
    assert turned_deg(3.0, 5.0, **CONTROL) == pytest.approx(3.0 - 2.0)
    assert turned_deg(0.0, 40.0, **CONTROL) == pytest.approx(-6.0)
    assert turned_deg(0.0, -40.0, **CONTROL) == pytest.approx(6.0)


def test_high_gain_corrects_in_one_frame_and_does_not_overshoot():
    assert turned_deg(0.0, 5.0, dt_s=0.1, gain_per_s=100.0, most_deg_s=1000.0) == pytest.approx(-5.0)


def test_perfect_reading_ends_upright_as_an_exponential():
    error = 10.0
    for _ in range(15):
        error = 10.0 + turned_deg(error - 10.0, error, **CONTROL)
    assert error == pytest.approx(10.0 * 0.6**15)


def test_gravity_turns_against_the_gripper():
    assert down_at(0.0) == pytest.approx((0.0, 1.0, 0.0))
    assert down_at(90.0) == pytest.approx((1.0, 0.0, 0.0))
    x, y, _ = down_at(25.0)
    wrist = math.radians(25.0)  # back in the room it points as it did
    assert (math.cos(wrist) * x - math.sin(wrist) * y, math.sin(wrist) * x + math.cos(wrist) * y) == pytest.approx(
        (0.0, 1.0)
    )


def test_line_has_no_sense():
    assert [line_angle_deg(each) for each in (0.0, 91.0, -91.0, 180.0, 90.0, -90.0)] == [0.0, -89.0, 89.0, 0.0, 90, 90]
