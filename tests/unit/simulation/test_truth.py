from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import box_lattice
from magicsim.geometry.pose import Pose
from magicsim.simulation.truth import contact_mask, depth_map_mm

PLANES = (np.linspace(-4, 4, 9), np.linspace(-3, 3, 7), np.array([0.0, 2.0]))
LANDING = np.stack(np.meshgrid(np.linspace(-3, 3, 13), np.linspace(2, -2, 9)), -1)


@pytest.fixture
def rest() -> Deformation:
    return Deformation.rest(box_lattice(PLANES, shear_modulus_mpa=1.0, lame_mpa=1.0))


def pressed(rest: Deformation, depth) -> Deformation:
    points = rest.contact_points_mm.copy()
    points[:, 2] = depth(points[:, 0], points[:, 1])
    return replace(rest, contact_points_mm=points, pose=Pose(position_mm=np.zeros(3), rotation=np.eye(3)))


def test_contact_mask_ends_where_the_gap_between_points_does(rest: Deformation):
    state = pressed(rest, lambda x, _: 0 * x)
    gap = 0.01 + 0.2 * (state.contact_points_mm[:, 0] - 0.6)
    found = contact_mask(replace(state, contact_gap_mm=gap), LANDING)
    assert np.array_equal(found, LANDING[..., 0] <= 0.6)
    assert not contact_mask(replace(state, contact_gap_mm=gap + 2.0), LANDING).any()
    assert not contact_mask(rest, LANDING).any()


def test_depth_map_of_the_untouched_sensor_is_zero(rest: Deformation):
    assert not depth_map_mm(rest, LANDING).any()


def test_depth_map_is_the_faces_height_where_the_pixels_look(rest: Deformation):
    found = depth_map_mm(pressed(rest, lambda x, y: 0.3 + 0.05 * x - 0.02 * y), LANDING)
    np.testing.assert_allclose(found, 0.3 + 0.05 * LANDING[..., 0] - 0.02 * LANDING[..., 1], atol=1e-6)
    assert found.dtype == np.float32


def test_depth_map_follows_points_that_moved_sideways(rest: Deformation):
    state = pressed(rest, lambda x, _: 0.1 * x)
    moved = replace(state, contact_points_mm=state.contact_points_mm + np.array([0.5, 0, 0]))
    np.testing.assert_allclose(depth_map_mm(moved, LANDING), 0.1 * (LANDING[..., 0] - 0.5), atol=1e-6)


def test_pixels_beyond_the_outermost_points_see_the_nearest_one(rest: Deformation):
    far = np.array([[[50.0, 0.0]]])
    state = pressed(rest, lambda x, _: 0.1 * x)
    assert depth_map_mm(state, far)[0, 0] == pytest.approx(0.1 * rest.contact_points_mm[:, 0].max())
