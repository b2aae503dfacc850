"""A face that is drawn settles outside the object, and nothing behind it is inverted."""

import numpy as np
import pytest

from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.simulation.meshes import face_distance, interior_distance, settle


@pytest.mark.parametrize("text", ["sphere:radius_mm=3", "box:size_mm=2x2x4", "cylinder:radius_mm=1"])
@pytest.mark.parametrize("clearance_mm", [0.01, -0.005])
def test_no_face_point_lies_deeper_than_the_clearance(text: str, clearance_mm: float) -> None:
    indenter = place_object(parse_object(text), gap_mm=-0.05)
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, 61), np.linspace(-1.5, 1.5, 61))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    settled = settle(points, np.ones(len(points), bool), indenter.distance, clearance_mm)
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
    settled = settle(points, heights == 0, indenter.distance, 0.01)
    assert (np.diff(settled[:, 2]) > 0).all()
    np.testing.assert_array_equal(settled[-1], points[-1])


def test_distances_after_settling_increase() -> None:
    distance = np.linspace(-0.1, 0.5, 2001)
    for clearance in (0.01, -0.01):
        assert (np.diff(face_distance(distance, clearance, max(0.01, clearance))) >= 0).all()
        inner = interior_distance(distance, clearance)
        assert (np.diff(inner) > 0).all()
        assert (inner > clearance).all()
