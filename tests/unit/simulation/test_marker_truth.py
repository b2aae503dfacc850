"""Where markers are, displaced and not, and that the table holds them."""

import numpy as np
import pytest

from magicsim.deform.lattice.structure import build_lattice
from magicsim.light.world.lamp_shapes import marker_disks
from magicsim.scenes.scene import load_scene
from magicsim.simulation.meshes import marker_map
from magicsim.simulation.plan import plan_scene

SMALL = ("design.footprint_mm=[10,10]", "rig.camera.field_mm=8")


@pytest.mark.parametrize("depth_mm", [0.0, 0.6])
def test_markers_follow_the_lattice(depth_mm):
    scene = load_scene("see-through-markers", [*SMALL, f"design.markers.depth_mm={depth_mm}"])
    lattice = build_lattice(scene.design)
    tracks = marker_map(scene.design, lattice)
    assert len(tracks.points_mm) == 25
    assert (tracks.points_mm[:, 2] == depth_mm).all()
    np.testing.assert_array_equal(tracks.displaced(np.zeros_like(lattice.nodes_mm)), tracks.points_mm)
    stretch = lattice.nodes_mm * [0.1, -0.05, 0.2] + [0.0, 0.3, 0.0]
    moved = tracks.displaced(stretch)
    np.testing.assert_allclose(moved, tracks.points_mm * [1.1, 0.95, 1.2] + [0, 0.3, 0], atol=1e-9)


@pytest.mark.parametrize("depth_mm", [0.0, 0.6])
def test_markers_of_a_curved_face_stand_as_deep_below_it(depth_mm):
    dome = "design.face={kind='dome',radius_x_mm=12,radius_y_mm=16,crown_mm=1.0,rim_mm=0.2}"
    scene = load_scene("see-through-markers", [*SMALL, dome, f"design.markers.depth_mm={depth_mm}"])
    lattice = build_lattice(scene.design)
    tracks = marker_map(scene.design, lattice)
    places, rise = tracks.points_mm, scene.design.rise_mm(tracks.points_mm[:, :2])
    assert rise.max() > 0.5
    share = 1 - rise / scene.design.height_mm
    np.testing.assert_allclose(places[:, 2], rise + depth_mm * share, atol=1e-9)
    np.testing.assert_allclose(tracks.displaced(np.zeros_like(lattice.nodes_mm)), places)
    moved = tracks.displaced(lattice.nodes_mm * [0.1, -0.05, 0.2])
    np.testing.assert_allclose(moved, places * [1.1, 0.95, 1.2], atol=0.02)
    disks = marker_disks(scene.design)
    assert disks is None or disks.vertices[:, 2].min() == pytest.approx(places[:, 2].min())


def test_design_without_markers_has_no_tracks():
    scene = load_scene("rest", SMALL)
    assert marker_map(scene.design, build_lattice(scene.design)) is None


def test_plan_of_a_coated_sensor_renders_touches_alone_and_says_why():
    scene = load_scene("gelsight-type")
    plan = plan_scene(scene)
    rendered = [frame for frame in plan.frames if frame.same_as is None]
    assert rendered
    assert all(frame.state.gap_mm is not None and frame.state.gap_mm < 0 for frame in rendered)
    assert any("coat is opaque" in decision.reason for decision in plan.left_out)
    assert not any("membrane" in decision.stage for decision in plan.kept)
    everything = plan_scene(scene, leave_out=False)
    assert all(frame.same_as is None for frame in everything.frames)


def test_plan_says_what_a_coat_adds_that_is_felt():
    felt = ["design.coat.thickness_mm=0.05", "design.coat.modulus_mpa=2"]
    plan = plan_scene(load_scene("gelsight-type", felt))
    assert any(each.stage == "coat as a membrane" and "0.1 N/mm" in each.reason for each in plan.kept)
    assert any(each.stage == "bending of the coat" and "0.082 mm" in each.reason for each in plan.left_out)
