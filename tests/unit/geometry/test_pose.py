import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.geometry.pose import Pose

ANGLE = st.floats(-360.0, 360.0)
AXES = np.eye(3)


@given(roll=ANGLE, pitch=ANGLE, yaw=ANGLE)
def test_rotation_is_proper(roll: float, pitch: float, yaw: float):
    rotation = Pose.from_degrees(np.zeros(3), roll=roll, pitch=pitch, yaw=yaw).rotation
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@given(roll=ANGLE, pitch=ANGLE, yaw=ANGLE)
def test_points_return_from_the_sensor_frame(roll: float, pitch: float, yaw: float):
    pose = Pose.from_degrees(np.array([1.0, -2.0, 3.0]), roll=roll, pitch=pitch, yaw=yaw)
    points = np.array([[0.0, 0.0, 0.0], [4.0, -5.0, 6.0]])
    assert pose.to_object(pose.to_sensor(points)) == pytest.approx(points, abs=1e-12)
    assert pose.to_sensor(points)[0] == pytest.approx([1.0, -2.0, 3.0])


@pytest.mark.parametrize(
    ("angles", "x_goes_to", "y_goes_to"),
    [
        ({"roll": 90.0}, AXES[0], AXES[2]),
        ({"pitch": 90.0}, -AXES[2], AXES[1]),
        ({"yaw": 90.0}, AXES[1], -AXES[0]),
    ],
)
def test_positive_angles_turn_by_the_right_hand_rule(
    angles: dict[str, float], x_goes_to: np.ndarray, y_goes_to: np.ndarray
):
    turned = Pose.from_degrees(np.zeros(3), **angles).to_sensor(AXES)
    assert turned[0] == pytest.approx(x_goes_to, abs=1e-12)
    assert turned[1] == pytest.approx(y_goes_to, abs=1e-12)


def test_roll_comes_first_then_pitch_then_yaw_about_fixed_axes():
    def turn(**angle: float) -> np.ndarray:
        return Pose.from_degrees(np.zeros(3), **angle).rotation

    together = turn(roll=20.0, pitch=-35.0, yaw=70.0)
    assert together == pytest.approx(turn(yaw=70.0) @ turn(pitch=-35.0) @ turn(roll=20.0))
    # y is rolled onto z, pitched onto x, yawed onto y
    assert Pose.from_degrees(np.zeros(3), roll=90, pitch=90, yaw=90).to_sensor(AXES)[1] == pytest.approx(
        AXES[1], abs=1e-12
    )


def test_key_tells_poses_apart():
    pose = Pose.from_degrees(np.array([1.0, 2.0, 3.0]), yaw=10.0)
    assert pose.key() == Pose.from_degrees(np.array([1.0, 2.0, 3.0]), yaw=10.0).key()
    assert pose.key() != Pose.from_degrees(np.array([1.0, 2.0, 3.0]), yaw=11.0).key()
    assert pose.key() != Pose.from_degrees(np.array([1.0, 2.0, 3.5]), yaw=10.0).key()
