import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.pose import Pose
from magicsim.robot.grip.load import Load

LEVEL = Pose(position_mm=np.zeros(3), rotation=np.eye(3))


def test_weight_pulls_down_whatever_the_length_of_the_direction():
    assert Load(weight_n=2, down=(0, -3, 0)).wrench(LEVEL) == pytest.approx([0, -2, 0, 0, 0, 0])
    assert Load.of_mass(100).wrench(LEVEL)[1] == pytest.approx(-0.980665)


def test_weight_off_the_origin_turns_the_object_with_its_own_orientation():
    load = Load(weight_n=2, centre_mm=(3, 0, 0), torque_nmm=(0, 0, 1))
    assert load.wrench(LEVEL)[3:] == pytest.approx([0, 0, -6 + 1])
    turned = Pose.from_degrees(np.zeros(3), yaw=90)
    assert load.wrench(turned)[3:] == pytest.approx([0, 0, 1])  # below the weight's line


@pytest.mark.parametrize("values", [{"weight_n": -1}, {"down": (0, 0, 0)}, {"force_n": (0, float("nan"), 0)}])
def test_impossible_load_is_refused(values: dict[str, object]):
    with pytest.raises(ConfigError, match=r"load\.\w+ = .*not allowed"):
        Load(**values)
