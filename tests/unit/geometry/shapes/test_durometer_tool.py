"""The durometer's cone and foot."""

import numpy as np
import pytest

from magicsim.geometry.shapes.revolved import DurometerTool


def test_tip_is_flat_and_at_the_origin() -> None:
    distance, normal = DurometerTool(1.0, None).distance(np.array([[0, 0, 0.5], [0.3, 0, 0.1], [0, 0.3, -0.05]]))
    np.testing.assert_allclose(distance, [0.5, 0.1, -0.05], atol=1e-12)
    np.testing.assert_allclose(normal, [[0, 0, 1]] * 3, atol=1e-12)


def test_cone_opens_by_35_degrees_from_079_to_125_millimetres() -> None:
    bare = DurometerTool(2.5, None)
    flank = np.array([0.395 + 0.3 * np.tan(np.radians(17.5)), 0.0, -0.3])
    outward = np.array([np.cos(np.radians(17.5)), 0, np.sin(np.radians(17.5))])
    distance, normal = bare.distance(np.stack([flank, flank + 0.2 * outward]))
    np.testing.assert_allclose(distance, [0, 0.2], atol=1e-9)
    np.testing.assert_allclose(normal[1], outward, atol=1e-9)
    assert bare.distance(np.array([[0.725, 0, -2.0]]))[0][0] == pytest.approx(0.1)


def test_foot_is_a_plane_with_a_hole_below_the_tip() -> None:
    tool = DurometerTool(1.2, 1.5)
    distance, normal = tool.distance(np.array([[3.0, 0, -1.0], [0, 5.0, -1.3], [1.4, 0, -3.0], [10.0, 0, -1.2]]))
    np.testing.assert_allclose(distance, [0.2, -0.1, 0.1, 1.0], atol=1e-9)
    np.testing.assert_allclose(normal[:3], [[0, 0, 1], [0, 0, 1], [-1, 0, 0]], atol=1e-9)
    assert tool.support_mm(np.array([0.0, 0.0, 1.0])) == pytest.approx(0)
