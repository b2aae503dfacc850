from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.contact.face import contact_face, point_boxes_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.deform.taxels import TaxelGrid, TaxelMap
from magicsim.geometry.design import load_design
from magicsim.geometry.pose import Pose

PLANES = (np.array([-4.0, -1.0, 0.5, 4.0]), np.linspace(-3, 3, 5), np.array([0.0, 2.0]))


@pytest.fixture
def lattice() -> Lattice:
    return box_lattice(PLANES, shear_modulus_mpa=1.0, lame_mpa=1.0)


def test_boxes_of_the_contact_points_tile_the_face_around_them(lattice: Lattice):
    face = contact_face(lattice)
    low, high = point_boxes_mm(lattice)
    np.testing.assert_allclose((high - low).prod(1), face.area_mm2, rtol=1e-12)
    np.testing.assert_allclose((high + low) / 2, face.positions(lattice.nodes_mm)[:, :2], atol=1e-12)


def test_taxels_share_the_whole_face(lattice: Lattice):
    shares = TaxelMap.of(lattice, TaxelGrid.over(lattice, rows=5, columns=7)).share_mm2
    np.testing.assert_allclose(np.asarray(shares.sum(0)).ravel(), contact_face(lattice).area_mm2, rtol=1e-12)
    np.testing.assert_allclose(np.asarray(shares.sum(1)).ravel(), 48 / 35, rtol=1e-12)


def test_rows_begin_at_plus_y_and_columns_at_minus_x(lattice: Lattice):
    centres = TaxelGrid.over(lattice, rows=3, columns=4).centres_mm
    np.testing.assert_allclose(centres[0, 0], [-3.0, 2.0])
    np.testing.assert_allclose(centres[2, 3], [3.0, -2.0])


def test_largest_value_is_that_of_every_box_a_taxel_overlaps(lattice: Lattice):
    grid = TaxelGrid.over(lattice, rows=2, columns=2)
    values = np.arange(12.0).reshape(4, 3)
    found = grid.largest(PLANES[0], PLANES[1], values)
    np.testing.assert_array_equal(found, [[10, 11], [4, 5]])


def test_largest_value_beyond_the_boxes_is_the_nearest_ones(lattice: Lattice):
    grid = TaxelGrid.over(lattice, rows=1, columns=8)
    found = grid.largest(np.array([-1.0, 0.0, 1.0]), np.array([-3.0, 3.0]), np.array([[1.0, 2.0]]))
    np.testing.assert_array_equal(found, [[1, 1, 1, 1, 2, 2, 2, 2]])


def test_deformation_of_another_solver_is_refused_with_what_it_lacks(lattice: Lattice):
    touched = Deformation.rest(lattice)
    other = TaxelMap.of(lattice, TaxelGrid.over(lattice, rows=2, columns=2), point_spacing_mm=3.0)
    assert not other.forces(touched).force_n.any()  # at rest nothing is known to be elsewhere
    moved = replace(touched, pose=Pose(position_mm=np.zeros(3), rotation=np.eye(3)))
    with pytest.raises(ValueError, match=r"contact points: must be the \d+ of this map"):
        other.forces(moved)


def test_taxels_of_a_domed_face_have_its_own_area():
    design = load_design(
        "uniform-block", ["footprint_mm=[10,10]", 'face={kind="dome",radius_x_mm=12,radius_y_mm=12,crown_mm=1.5}']
    )
    lattice = build_lattice(design)
    shares = TaxelMap.of(lattice, TaxelGrid.over(lattice, rows=4, columns=4)).share_mm2
    assert shares.sum() == pytest.approx(contact_face(lattice).area_mm2.sum(), rel=1e-12)
    assert shares.sum() > 100
