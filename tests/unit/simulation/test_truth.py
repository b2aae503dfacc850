from dataclasses import replace

import numpy as np
import pytest

from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import box_lattice
from magicsim.geometry.limits import PressLimits
from magicsim.geometry.pose import Pose
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.truth import contact_mask, depth_map_mm, frame_truth, is_in_view

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


def test_light_touch_is_labelled_and_a_hard_one_is_beyond_limits(rest: Deformation):
    limits = PressLimits(force_n=6.0)
    found = []
    for gap_mm, force_n, is_reference in ((-0.1, 0.5, False), (-0.1, 0.5, True), (-1.0, 7.0, False), (1.0, 0.0, False)):
        state = replace(UNTOUCHED, gap_mm=gap_mm)
        touched = replace(rest, force_n=np.array([0.0, 0.0, force_n]), contact_area_mm2=20.0)
        truth = frame_truth(state, touched, limits, index=0, time_s=0.0, is_reference=is_reference)
        found.append((truth.label, bool(truth.beyond_limits)))
    assert found == [("Light touch", False), ("", False), ("Contact", True), ("Near", False)]


def test_touch_is_in_view_where_the_picture_covers_what_presses(rest: Deformation):
    view = np.array([[-4.0, -1.0], [4.0, 1.0]])
    place = replace(UNTOUCHED, gap_mm=-0.5, x_mm=0.0, y_mm=2.0)
    assert not is_in_view(place, rest, view)  # its origin is outside, and nothing presses
    assert is_in_view(replace(place, y_mm=0.5), rest, view)
    assert is_in_view(UNTOUCHED, rest, view)
    near = np.exp(-np.linalg.norm(rest.contact_points_mm[:, :2] - [1.0, 0.5], axis=1))
    pressing = replace(rest, contact_pressure_mpa=np.where(near > np.exp(-0.4), near, 0.0))
    assert is_in_view(place, pressing, view)  # the part that presses is inside, such as the blade of a pair of scissors
