from pathlib import Path

import pytest
import trimesh

from magicsim.scenes.field_check import field_warnings
from magicsim.scenes.scene import load_scene


def told(name: str, *settings: str) -> list[str]:
    return field_warnings(load_scene(name, settings))


@pytest.mark.parametrize("name", ["demo", "rest", "near", "pressed", "flashlight", "grip"])
def test_shipped_scenes_fit_their_block(name: str):
    assert told(name) == []


def test_camera_past_the_block_is_told_with_a_field_that_stays_inside():
    [line] = told("rest", "design.footprint_mm=[18, 32]")
    assert "past the block of 18 x 32 mm" in line
    assert "along x" in line
    assert "along y" not in line
    width = line.split("field_mm = ")[1].split()[0]
    assert told("rest", "design.footprint_mm=[18, 32]", f"rig.camera.field_mm={width}") == []
    assert told("rest", "design.footprint_mm=[18, 32]", f"rig.camera.field_mm={float(width) + 0.2}")


def test_object_larger_than_the_sensor_is_told():
    [line] = told("near", "object=orange")
    assert "72 x 72 mm before a contact face of 24 x 32 mm" in line
    assert told("near", "object={kind='box', size_mm=[20, 30, 5]}") == []
    assert told("near", "object={kind='box', size_mm=[30, 20, 5]}")
    assert told("near", "object={kind='box', size_mm=[30, 20, 5], yaw_deg=90}") == []


def test_object_on_the_rim_is_told_with_the_first_keyframe_that_presses_there():
    moved = "keyframes=[{frame=0, gap_mm=-0.5}, {frame=4, gap_mm=-0.5, x_mm=11.5}, {frame=5, gap_mm=2.0, x_mm=11.5}]"
    [line] = told("near", moved)
    assert "from keyframe 4 on" in line


def test_rim_of_a_dome_lies_higher_than_its_crown():
    pressed = "keyframes=[{frame=0, gap_mm=-1.0}]"
    plate = "object={kind='box', size_mm=[23.9, 31.9, 5], edge_radius_mm=1}"
    assert told("mini-magictac-finger", plate, pressed) == []
    [line] = told("mini-magictac-finger", plate.replace("23.9", "30"), pressed.replace("1.0", "3.0"))[1:]
    assert "presses on the rim of the contact face from keyframe 0 on" in line


def test_mesh_whose_origin_is_far_from_it_is_told(tmp_path: Path):
    ball = trimesh.creation.icosphere(radius=3)
    ball.apply_translation((50, 60, 70))
    ball.export(tmp_path / "ball.stl")
    thing = f"object={{kind='mesh', path='{tmp_path / 'ball.stl'}'}}"
    [line] = told("near", thing)
    assert "never before the contact face" in line
    assert "47 to 53 mm along x and 57 to 63 mm along y" in line
    assert told("near", thing, "keyframes=[{frame=0, gap_mm=1.0}, {frame=2, gap_mm=-0.5, x_mm=-50, y_mm=-60}]") == []
