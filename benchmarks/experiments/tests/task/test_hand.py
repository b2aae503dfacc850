import numpy as np
import pytest

from magicsim.robot.fingers import ObjectPlace, half_extents_mm, object_pose
from magicsim_experiments.task.hand import CLEAR_MM, MOST, SKIN, hand_mesh, hand_pose
from magicsim_experiments.task.settings import load_item

ITEMS = {name: load_item(name).object for name in ("orange", "banana", "biscuit-packet", "pen")}


@pytest.mark.parametrize("item", ITEMS.values(), ids=ITEMS)
def test_hand_holds_the_item_from_the_front_and_leaves_both_faces_free(item):
    hand = hand_mesh(item)
    up, down = half_extents_mm(item)
    assert hand.is_watertight()
    assert hand.vertices[:, 2].max() <= up - CLEAR_MM + 1e-3
    assert hand.vertices[:, 2].min() >= CLEAR_MM - down - 1e-3
    to_object = object_pose(item, ObjectPlace()).to_object
    distance = item.shape().distance(to_object(hand.vertices))[0]
    assert -1.0 < distance.min() < 1.0  # it touches, and skin gives way a little
    ahead = item.shape().support_mm(object_pose(item, ObjectPlace()).rotation[1])
    assert hand.vertices[:, 1].max() > ahead + 20 * (up - CLEAR_MM) / 8 / MOST  # the arm, in front of it


def test_thumb_is_on_one_side_and_fingers_on_the_other():
    hand = hand_mesh(ITEMS["orange"])
    beside = hand.vertices[np.abs(hand.vertices[:, 1]) < 5]
    thumb, fingers = beside[beside[:, 0] < 0], beside[beside[:, 0] > 0]
    assert np.ptp(fingers[:, 2]) == pytest.approx(4 * np.ptp(thumb[:, 2]), rel=0.15)
    assert hand.colors is not None
    assert (hand.colors == SKIN).all()


def test_hand_goes_with_the_item_and_leaves_to_the_front():
    place = ObjectPlace(x_mm=1.0, y_mm=2.0, z_mm=3.0, twist_deg=90.0)
    pose = hand_pose(place, 7.0)
    np.testing.assert_allclose(pose.to_sensor(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])), [[1, 9, 3], [1, 10, 3]])
