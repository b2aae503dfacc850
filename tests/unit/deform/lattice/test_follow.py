"""Points follow the lattice exactly for affine fields and settle outside the object."""

import numpy as np
import pytest

from magicsim.deform.lattice.follow import follow_map
from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.settle import face_distance, interior_distance, settle
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

LATTICE = box_lattice(
    (np.array([-2.0, -0.5, 2.0]), np.linspace(-1, 1, 4), np.array([0.0, 0.8, 3.0])), shear_modulus_mpa=1, lame_mpa=1
)


def test_affine_motion_is_reproduced() -> None:
    gradient = np.random.default_rng(0).normal(size=(3, 3))
    points = np.random.default_rng(1).uniform([-2, -1, 0], [2, 1, 3], (500, 3))
    moved = follow_map(LATTICE, points).displaced(LATTICE.nodes_mm @ gradient.T + 0.3)
    np.testing.assert_allclose(moved, points + points @ gradient.T + 0.3, atol=1e-12)


def test_nodes_follow_themselves_and_outside_points_the_nearest() -> None:
    displacements = np.random.default_rng(2).normal(size=LATTICE.nodes_mm.shape)
    followed = follow_map(LATTICE, LATTICE.nodes_mm).displaced(displacements)
    np.testing.assert_allclose(followed, LATTICE.nodes_mm + displacements, atol=1e-12)
    outside = LATTICE.nodes_mm[:1] - [1, 1, 1]
    moved = follow_map(LATTICE, outside).displaced(displacements)
    np.testing.assert_allclose(moved - outside, displacements[:1], atol=1e-12)


@pytest.mark.parametrize("text", ["sphere:radius_mm=3", "box:size_mm=2x2x4", "cylinder:radius_mm=1"])
@pytest.mark.parametrize("clearance_mm", [0.01, -0.005])
def test_no_face_point_lies_deeper_than_the_clearance(text: str, clearance_mm: float) -> None:
    indenter = place_object(parse_object(text), gap_mm=-0.05)
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, 61), np.linspace(-1.5, 1.5, 61))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    settled = settle(points, np.ones(len(points), bool), indenter, clearance_mm)
    distance = indenter.distance(settled)[0]
    assert distance.min() >= clearance_mm - 1e-4
    touched = indenter.distance(points)[0] <= 0.0
    np.testing.assert_allclose(distance[touched], clearance_mm, atol=1e-4)
    far = indenter.distance(points)[0] > 0.3
    assert np.array_equal(settled[far], points[far])


def test_interior_points_stay_behind_the_face() -> None:
    indenter = place_object(parse_object("sphere:radius_mm=3"), gap_mm=-0.06)
    heights = np.array([0.0, 0.02, 0.05, 0.1, 0.3, 1.0])
    points = np.stack([np.zeros(6), np.zeros(6), heights], 1)
    settled = settle(points, heights == 0, indenter, 0.01)
    assert (np.diff(settled[:, 2]) > 0).all()
    np.testing.assert_array_equal(settled[-1], points[-1])


def test_distances_after_settling_increase() -> None:
    distance = np.linspace(-0.1, 0.5, 2001)
    for clearance in (0.01, -0.01):
        assert (np.diff(face_distance(distance, clearance, max(0.01, clearance))) >= 0).all()
        inner = interior_distance(distance, clearance)
        assert (np.diff(inner) > 0).all()
        assert (inner > clearance).all()
