import numpy as np
import pytest

from magicsim.config.presets import preset_names
from magicsim.errors import ConfigError, PresetError
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.everyday import banana_section, fluted_handle, scissor_loops, spanner_head, tube
from magicsim.geometry.objects.kinds import find_object, parse_object
from magicsim.scenes.scene import load_scene


@pytest.mark.parametrize("name", preset_names("object"))
def test_every_object_is_a_closed_solid_that_touches_at_gap_zero(name: str):
    thing = find_object(name)
    mesh = thing.shape().mesh()
    assert mesh.is_watertight()
    assert mesh.volume_mm3() > 0
    placed = place_object(thing, gap_mm=0.0)
    assert placed.pose.to_sensor(mesh.vertices)[:, 2].max() == pytest.approx(0.0, abs=0.02)
    assert thing == parse_object(name)


@pytest.mark.parametrize("name", ["silver-spanner", "red-screwdriver", "yellow-scissors", "yellow-banana"])
def test_distance_is_that_to_the_drawn_surface(name: str):
    shape = find_object(name).shape()
    vertices = shape.mesh().vertices
    vertices = vertices[:: max(1, len(vertices) // 200)]
    distance, normal = shape.distance(vertices)
    assert np.abs(distance).max() < 1e-6
    away, _ = shape.distance(vertices + 0.02 * normal)
    assert np.mean(np.abs(away - 0.02) < 1e-6) > 0.9  # all but those in concave corners


def test_spanner_has_a_jaw_of_its_width_and_rounded_edges():
    solid = spanner_head(10.0, 11.0, 8.0, 5.0, 0.6)
    low, high = np.array(solid.bounding_box()).reshape(2, 3)
    assert (high - low)[2] == pytest.approx(5.0, abs=1e-6)
    # Across the open jaw, in the middle of the thickness: two prongs with 10 mm between them.
    turned = solid.rotate((0, 0, -15)).slice(0.0)
    inside = [polygon[np.abs(polygon[:, 1] - 6.6) < 4] for polygon in map(np.array, turned.to_polygons())]
    across = np.concatenate(inside)[:, 0]
    assert np.abs(across).min() == pytest.approx(5.0, abs=0.05)


def test_handle_fills_between_its_core_and_its_outer_cylinder():
    volume = fluted_handle(11.0, 45.0, 6).volume()
    assert 0.6 * np.pi * 11**2 * 45 < volume < np.pi * 11**2 * 45
    smooth = fluted_handle(11.0, 45.0, 12).volume()
    assert smooth < volume


def test_straight_tube_has_the_volume_of_a_capsule():
    solid = tube(np.array([[0.0, 0, 0], [0, 10, 0]]), np.array([2.0, 2.0]))
    assert solid.volume() == pytest.approx(np.pi * 4 * 10 + 4 / 3 * np.pi * 8, rel=0.03)


def test_loops_are_two_rings_with_a_gap_and_the_banana_is_bent():
    loops = scissor_loops(20.0, 30.0, 3.5, 2.0)
    assert loops.genus() == 2 or len(loops.decompose()) == 2
    section = loops.slice(0.0)
    xs = np.concatenate([np.array(each) for each in section.to_polygons()])
    near_middle = xs[np.abs(xs[:, 1]) < 1.0, 0]
    assert np.abs(near_middle).min() == pytest.approx(1.0, abs=0.05)
    straight, bent = banana_section(17.0, 60.0, 1000.0), banana_section(17.0, 60.0, 60.0)
    low = [np.array(each.bounding_box()).reshape(2, 3)[0, 2] for each in (straight, bent)]
    assert low[1] < low[0] - 2  # its ends hang down


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("spanner:jaw_mm=21,edge_radius_mm=0.6", "edge_radius_mm = 0.6 is not allowed"),
        ("spanner:jaw_mm=30", "jaw_mm = 30 is not allowed: must be below 22"),
        ("screwdriver:radius_mm=9,length_mm=8", "length_mm = 8 is not allowed"),
        ("screwdriver:radius_mm=9,flutes=1", "flutes = '1' is not allowed"),
        ("banana:radius_mm=30,bend_radius_mm=25", "bend_radius_mm = 25 is not allowed"),
        ("orangge", "did you mean 'orange'"),
    ],
)
def test_impossible_object_is_refused(text: str, words: str):
    with pytest.raises(ConfigError) as caught:
        parse_object(text)
    assert words in str(caught.value)


def test_scene_takes_an_object_by_name():
    scene = load_scene("near", ["object=orange", "object.radius_mm=30"])
    assert scene.object.kind == "sphere"
    assert scene.object.radius_mm == 30
    assert scene.object.color == find_object("orange").color
    with pytest.raises(PresetError, match="unknown object 'appel'"):
        load_scene("near", ["object=appel"])
