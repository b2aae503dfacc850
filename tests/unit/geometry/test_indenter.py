import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

OBJECTS = ["sphere:radius_mm=4", "box:size_mm=3x4x8", "cylinder:radius_mm=2,length_mm=12", "punch:radius_mm=3"]
ANGLE = st.integers(-180, 180)


@pytest.mark.parametrize("text", OBJECTS)
@given(roll=ANGLE, pitch=ANGLE, yaw=ANGLE, gap=st.floats(-3.0, 30.0))
def test_highest_point_is_at_minus_the_gap_for_any_orientation(text: str, roll: int, pitch: int, yaw: int, gap: float):
    config = parse_object(f"{text},roll_deg={roll},pitch_deg={pitch},yaw_deg={yaw}")
    placed = place_object(config, gap_mm=gap, x_mm=1.0, y_mm=-2.0, twist_deg=15.0)
    assert placed.top_mm() == pytest.approx(-gap, abs=1e-9)
    assert placed.pose.position_mm[:2] == pytest.approx([1.0, -2.0])


@pytest.mark.parametrize("text", OBJECTS)
def test_highest_vertex_of_the_placed_mesh_is_at_minus_the_gap(text: str):
    config = parse_object(f"{text},roll_deg=25,pitch_deg=-40")
    placed = place_object(config, gap_mm=0.7, twist_deg=33.0)
    top = placed.pose.to_sensor(placed.shape.mesh().vertices)[:, 2].max()
    assert top == pytest.approx(-0.7, abs=5e-3)


@pytest.mark.parametrize(
    "text", ["box:size_mm=3x5x4,roll_deg=20,yaw_deg=30", "domed_cylinder:radius_mm=2,pitch_deg=40"]
)
def test_box_of_the_placed_object_is_that_of_its_mesh(text: str):
    placed = place_object(parse_object(text), gap_mm=-0.4, x_mm=1.5, y_mm=-2.0)
    vertices = placed.pose.to_sensor(placed.shape.mesh().vertices)
    low, high = placed.box_mm()
    np.testing.assert_allclose([low, high], [vertices.min(0), vertices.max(0)], atol=2e-3)
    assert high[2] == pytest.approx(placed.top_mm(), abs=1e-12)


def test_twist_adds_to_the_yaw_of_the_object():
    turned = place_object(parse_object("box:size_mm=2x3x4,yaw_deg=20,roll_deg=50"), gap_mm=1.0, twist_deg=30.0)
    same = place_object(parse_object("box:size_mm=2x3x4,yaw_deg=50,roll_deg=50"), gap_mm=1.0)
    assert turned.pose.rotation == pytest.approx(same.pose.rotation)
    assert turned.pose.position_mm == pytest.approx(same.pose.position_mm)


def test_distance_and_normal_are_in_the_frame_of_the_sensor():
    placed = place_object(parse_object("cylinder:radius_mm=2,length_mm=12,yaw_deg=90"), gap_mm=0.5)
    # along y in its own frame, so along x once turned, its axis at z = -2.5
    distance, normal = placed.distance(np.array([[5.0, 0.0, 0.0], [0.0, 5.0, -2.5], [8.0, 0.0, -2.5]]))
    assert distance == pytest.approx([0.5, 3.0, 2.0])
    assert normal == pytest.approx(np.array([[0, 0, 1], [0, 1, 0], [1, 0, 0]]), abs=1e-12)
