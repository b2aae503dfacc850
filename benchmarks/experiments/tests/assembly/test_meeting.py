"""What a base does to a plug, against statics done by hand."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.pose import Pose
from magicsim_experiments.assembly.meeting import FORWARD, Contact, Jack, MetLoad, plug_elements

PLUG = parse_object("plug:radius_mm=5")
TIP_MM = 16.0
HERE = Pose.from_degrees(np.zeros(3))
NO_SPRING = Contact(spring_n=0.0)
LOAD = replace(MetLoad(weight_n=0.1, down=(0.0, 1.0, 0.0)), elements=plug_elements(PLUG), contact=NO_SPRING)


def jack(x_mm: float, y_mm: float, z_mm: float, *, tilt_z_deg: float = 0.0) -> Pose:
    """From the jack's frame to the gripper's, by the middle of its mouth."""
    return Pose.from_degrees(np.array([x_mm, y_mm, z_mm]), yaw=tilt_z_deg)


def met(depth_mm: float, *, x_mm: float = 0.0, z_mm: float = 0.0, load: MetLoad = LOAD, way: float = 0.0) -> np.ndarray:
    return replace(load, base=jack(x_mm, TIP_MM - depth_mm, z_mm), way=way).met(HERE)


def test_elements_lie_on_the_plug_and_have_its_area():
    elements = plug_elements(PLUG)
    distance, normal = PLUG.solid().distance(elements.points_mm)
    assert np.abs(distance).max() < 1e-12
    np.testing.assert_allclose(normal, elements.normals, atol=1e-9)
    pin = 2 * np.pi * 2.5 * 10 + np.pi * 2.5**2
    assert elements.area_mm2.sum() == pytest.approx(pin + np.pi * (4.0**2 - 2.5**2), rel=0.01)


def test_plug_on_the_flat_base_meets_area_times_stiffness_times_depth():
    force = met(0.1, x_mm=20.0)
    rim = 2 * np.pi * 2.45 * 0.1 * np.pi / 4  # quarter of a circle of 0.1 mm, deep and seen as its sine
    assert -force[1] == pytest.approx(5.0 * 0.1 * (np.pi * 2.4**2 + rim), rel=0.01)
    np.testing.assert_allclose(force[[0, 2, 3, 4, 5]], 0, atol=1e-7)


def test_nothing_is_met_before_the_mouth_nor_in_the_middle_of_the_hole():
    assert not met(-0.01, x_mm=4.0).any()
    assert not met(6.0).any()


def test_wall_pushes_a_plug_that_sits_aside_to_the_middle():
    force = met(5.0, x_mm=0.3)
    assert force[0] > 0  # the hole is at +x
    assert abs(force[2]) < 1e-9
    np.testing.assert_allclose(met(5.0, z_mm=0.3)[2], force[0], rtol=1e-6)


def test_friction_adds_its_coefficient_against_the_motion():
    resting, sliding = met(5.0, x_mm=0.12), met(5.0, x_mm=0.12, way=FORWARD)
    share = (sliding[1] - resting[1]) / resting[0]
    assert -0.2 * 1.1 < share < -0.2  # the pressure on an arc of 33 degrees adds up to less than its sum
    assert (met(5.0, x_mm=0.12, way=-FORWARD)[1] - resting[1]) / resting[0] == pytest.approx(-share)


def test_springs_of_the_jack_resist_a_pin_in_the_hole_alone():
    load = replace(LOAD, contact=Contact(spring_n=1.5, spring_mm=(2.0, 4.0)))
    assert met(1.0, load=load, way=FORWARD)[1] == 0
    assert met(3.0, load=load, way=FORWARD)[1] == pytest.approx(-0.75)
    assert met(8.0, load=load, way=FORWARD)[1] == pytest.approx(-1.5)
    assert met(8.0, load=load, way=-FORWARD)[1] == pytest.approx(1.5)
    assert met(8.0, load=load)[1] == 0


def test_contact_alone_has_the_same_wrench_wherever_the_pair_stands():
    turn = Pose.from_degrees(np.array([3.0, -2.0, 1.0]), roll=20, pitch=-35, yaw=50)
    base = jack(0.4, TIP_MM - 3.0, 0.1, tilt_z_deg=4.0)
    force = replace(LOAD, base=base, way=FORWARD).met(HERE)
    moved = Pose(position_mm=turn.to_sensor(base.position_mm[None])[0], rotation=turn.rotation @ base.rotation)
    found = replace(LOAD, base=moved, way=FORWARD).met(turn)
    np.testing.assert_allclose(found[:3], turn.rotation @ force[:3], atol=1e-9)
    np.testing.assert_allclose(found[3:], turn.rotation @ force[3:], atol=1e-8)


def test_stiffness_is_that_of_the_wrench_and_weight_comes_with_it():
    load = replace(LOAD, base=jack(20.0, TIP_MM - 0.2, 0.0))
    assert load.stiffness(HERE)[1, 1] == pytest.approx(5.0 * np.pi * 2.5**2, rel=0.05)
    np.testing.assert_allclose(load.wrench(HERE)[1], load.met(HERE)[1] + 0.1)
    assert not LOAD.stiffness(HERE).any()
    assert Jack() == load.jack
