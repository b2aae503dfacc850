import numpy as np
import pytest
from pydantic import ValidationError

from magicsim_experiments.assembly.meeting import Jack

JACK = Jack(radius_mm=2.6, chamfer_mm=0.5, depth_mm=12.0)


@pytest.mark.parametrize(
    ("point", "distance", "normal"),
    [
        ((6.0, -1.0, 0.0), 1.0, (0, -1, 0)),
        ((0.0, 0.3, 6.0), -0.3, (0, -1, 0)),
        ((2.8, 5.0, 0.0), -0.2, (-1, 0, 0)),
        ((0.0, 5.0, -2.5), 0.1, (0, 0, 1)),
        ((0.0, 11.0, 0.0), 1.0, (0, -1, 0)),
        ((0.0, 12.5, 0.0), -0.5, (0, -1, 0)),
        ((2.85, 0.35, 0.0), -0.1 / np.sqrt(2), (-np.sqrt(0.5), -np.sqrt(0.5), 0)),
    ],
)
def test_distance_and_normal_on_face_wall_bottom_and_chamfer(
    point: tuple[float, ...], distance: float, normal: tuple[float, ...]
):
    found, outward = JACK.distance(np.array([point]))
    assert found[0] == pytest.approx(distance)
    np.testing.assert_allclose(outward[0], normal, atol=1e-9)


def test_normal_is_the_gradient_of_the_distance():
    rng = np.random.default_rng(0)
    points = rng.uniform((-5, -2, -5), (5, 14, 5), (400, 3))
    distance, normal = JACK.distance(points)
    step = 1e-6
    gradient = np.stack([(JACK.distance(points + step * axis)[0] - distance) / step for axis in np.eye(3)], 1)
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1) < 1e-4  # not across a ridge
    assert smooth.mean() > 0.95
    np.testing.assert_allclose(gradient[smooth], normal[smooth], atol=1e-3)


def test_impossible_hole_is_refused():
    with pytest.raises(ValidationError, match="radius_mm"):
        Jack(radius_mm=0)
