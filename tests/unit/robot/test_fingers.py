import numpy as np
import pytest

from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.robot.fingers import (
    SIDES,
    ObjectPlace,
    finger_motion,
    finger_pose,
    half_extents_mm,
    seen_by_lower,
)


@pytest.mark.parametrize("side", SIDES)
def test_finger_frames_are_right_handed_and_face_each_other(side: str):
    pose = finger_pose(side, 8.0)
    sign = 1 if side == "upper" else -1
    assert np.linalg.det(pose.rotation) == pytest.approx(1)
    assert pose.to_sensor(np.zeros((1, 3)))[0] == pytest.approx([0, 0, 4 * sign])  # the face
    assert pose.to_sensor(np.array([[1.0, 2.0, 3.0]]))[0] == pytest.approx([sign, 2, 7 * sign])


@pytest.mark.parametrize(
    "line", ["cone:half_angle_deg=40", "box:size_mm=3x5x7", "domed_cylinder:radius_mm=3", "sphere:radius_mm=4"]
)
def test_both_fingers_see_one_and_the_same_object(line: str):
    target = parse_object(line).model_copy(update={"roll_deg": 25.0, "pitch_deg": -35.0, "yaw_deg": 15.0})
    place, width = ObjectPlace(x_mm=1.5, y_mm=-2.0, z_mm=0.7, twist_deg=30.0, tilt_x_deg=8.0, tilt_y_deg=-5.0), 9.0
    extents = half_extents_mm(target, place)
    probes = np.random.default_rng(3).uniform(-9, 9, (200, 3))
    found = {}
    for side in SIDES:
        motion = finger_motion(side, place, width, extents)
        indenter = place_object(target if side == "upper" else seen_by_lower(target), **motion)
        mesh = indenter.pose.to_sensor(indenter.shape.mesh().vertices)
        found[side] = finger_pose(side, width).to_sensor(mesh)
        origin = finger_pose(side, width).to_sensor(indenter.pose.position_mm[None])[0]
        assert origin == pytest.approx([1.5, -2.0, 0.7])
        outside = indenter.shape.distance(indenter.pose.to_object(finger_pose(side, width).to_object(probes)))[0] > 0
        found[side, "outside"] = outside
    assert found["upper"] == pytest.approx(found["lower"])
    assert (found["upper", "outside"] == found["lower", "outside"]).mean() > 0.9  # contact treats the inside by entry


def test_object_that_a_finger_pushes_along_does_not_press_it_by_rounding():
    for number in range(1, 60):
        width, extents = 9.0 + number * 0.37, (4.1 + number * 0.01, 3.3)
        motion = finger_motion("upper", ObjectPlace(z_mm=width / 2 - extents[0]), width, extents)
        assert motion["gap_mm"] == 0


def test_gaps_add_up_to_the_width():
    extents = (4.0, 3.0)
    gaps = [finger_motion(side, ObjectPlace(z_mm=0.6), 9.0, extents)["gap_mm"] for side in SIDES]
    assert gaps == pytest.approx([4.5 - 0.6 - 4.0, 4.5 + 0.6 - 3.0])
    assert sum(gaps) == pytest.approx(9.0 - sum(extents))
