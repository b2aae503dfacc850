import numpy as np
import pytest
from laboratory.input_kinds import objects
from laboratory.input_kinds.program import SLOT, SLOT_MM3

from magicsim.errors import ConfigError
from magicsim.geometry.files.mesh_colors import file_colors
from magicsim.geometry.files.mesh_file import crossing_edges, load_mesh
from magicsim.geometry.files.polygons import cut_polygons, off_as_obj

HOLE = [(-3, -3), (3, -3), (3, 3), (-3, 3), (-1, -1), (-1, 1), (1, 1), (1, -1)]
KEYHOLE = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4]
"""A square with a square hole as one polygon, which walks to the hole and back."""


@pytest.mark.parametrize("first", range(8))
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_concave_polygons_of_a_ply_cover_their_own_ground(tmp_path, first: int, form: str):
    path = objects.write_ply(tmp_path / "slot.ply", *objects.plate(SLOT[first:] + SLOT[:first]), form=form)
    assert objects.unlike_plate(path) is None


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_triangles_keep_the_colour_of_their_polygon(tmp_path, form: str):
    path = objects.write_ply(tmp_path / "slot.ply", *objects.plate(SLOT), form=form)
    top, bottom = file_colors(path, np.array([[2.0, 0.0, 0.0], [2.0, 0.0, -3.0]]))
    assert top[2] == 0
    assert bottom[2] == pytest.approx(1 / 255 / 12.92, rel=1e-3)
    assert top[0] == pytest.approx(bottom[0])


@pytest.mark.parametrize("first", range(8))
@pytest.mark.parametrize("header", ["OFF\n", "COFF\n", "OFF # by hand\n\n", "OFF "])
def test_off_is_read_with_concave_polygons(tmp_path, first: int, header: str):
    path = objects.write_off(tmp_path / "slot.off", *objects.plate(SLOT[first:] + SLOT[:first]))
    text = (tmp_path / "slot.off").read_text()
    (tmp_path / "slot.off").write_text(text.replace("OFF # other tool\n", header))
    assert objects.unlike_plate(path) is None


@pytest.mark.parametrize(
    "content", ["OFF", "OFF\n8 6 0\n0 0 0\n", "4OFF\n1 1 0\n", "OFF BINARY\n1 1 0\n", "off\n", "OFF\n-1 3 0\n"]
)
def test_off_that_cannot_be_read_is_refused(tmp_path, content: str):
    (tmp_path / "a.off").write_text(content)
    with pytest.raises(ConfigError, match=r"a\.off' cannot be read: it"):
        load_mesh(str(tmp_path / "a.off"))


def test_points_and_lines_of_an_off_are_left_out():
    assert off_as_obj(b"OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n1 0\n2 0 1\n3 0 1 2\n").count(b"f ") == 1


@pytest.mark.parametrize("first", range(0, 16, 3))
def test_corners_in_the_middle_of_a_side_leave_no_flat_triangle(tmp_path, first: int):
    corners = objects.HALF_WAY[first:] + objects.HALF_WAY[:first]
    assert objects.unlike_plate(objects.write_obj(tmp_path / "slot.obj", objects.plate(corners))) is None
    square = [(-3, -3), (0, -3), (3, -3), (3, 3), (0, 3), (-3, 3)]
    solid = load_mesh(objects.write_obj(tmp_path / "square.obj", objects.plate(square))).surface
    a, b, c = (solid.vertices[solid.faces[:, corner]] for corner in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1
    assert crossing_edges(solid) == 0


def test_polygon_that_walks_to_a_hole_and_back_leaves_the_hole():
    points = np.array([(*each, 0.0) for each in HOLE])
    (triangles,) = cut_polygons(points, [KEYHOLE]).values()
    a, b, c = np.moveaxis(points[np.array(KEYHOLE)[np.array(triangles)]], 1, 0)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(36 - 4)


def test_convex_polygons_stay_as_they_are(tmp_path):
    square = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    assert cut_polygons(square, [[0, 1, 2, 3], [0, 1, 2], [0, 0, 1, 2]]) == {}
    with pytest.raises(ValueError, match="a vertex that is not there"):
        cut_polygons(square, [[0, 1, 2, 4]])


def test_volume_of_two_objects_in_one_obj_is_that_of_both(tmp_path):
    vertices, faces = objects.plate(SLOT)
    other = [(x + 20, y, z) for x, y, z in vertices]
    path = objects.write_obj(tmp_path / "slots.obj", (vertices, faces), (other, faces))
    assert load_mesh(path).surface.volume_mm3() == pytest.approx(2 * SLOT_MM3)
