from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import box_lattice
from magicsim.geometry.pose import Pose
from magicsim.robot.workspace import slip_mm, slip_share

PLANES = np.array([0.0, 1.0])
REST = Deformation.rest(box_lattice((PLANES, PLANES, PLANES), shear_modulus_mpa=1.0, lame_mpa=10.0))
COUNT = len(REST.contact_points_mm)
AREA = np.linspace(1, 2, COUNT)


def touching(pressure: np.ndarray, slipping: np.ndarray, shift: np.ndarray) -> Deformation:
    return replace(
        REST, pose=Pose(position_mm=np.zeros(3), rotation=np.eye(3)), contact_pressure_mpa=pressure,
        is_slipping=slipping, anchors_mm=REST.anchors_mm + shift,
    )  # fmt: skip


def test_share_weighs_by_force():
    pressure, slipping = np.zeros(COUNT), np.zeros(COUNT, bool)
    pressure[:3], slipping[1] = [1.0, 2.0, 3.0], True
    share = slip_share(touching(pressure, slipping, np.zeros(3)), AREA)
    assert share == pytest.approx(2 * AREA[1] / (AREA[:3] @ pressure[:3]))


def test_nothing_slips_at_rest():
    assert slip_share(REST, AREA) == 0
    assert slip_mm(REST, touching(np.ones(COUNT), np.ones(COUNT, bool), np.ones(3)), AREA) == 0


def test_way_is_that_of_the_anchors_where_contact_lasts():
    before, after = np.zeros(COUNT), np.zeros(COUNT)
    before[:3], after[1:4] = 1.0, [1.0, 3.0, 5.0]
    moved = np.zeros((COUNT, 3))
    moved[1], moved[2], moved[3] = [0.3, 0.4, 0.0], [0.0, 0.0, 0.0], [9.0, 0.0, 0.0]
    slid = slip_mm(
        touching(before, np.zeros(COUNT, bool), np.zeros(3)), touching(after, np.zeros(COUNT, bool), moved), AREA
    )
    assert slid == pytest.approx(0.5 * AREA[1] / (AREA[1] + 3 * AREA[2]))
