import numpy as np
import pytest

from magicsim.light.facing.glow import arriving

FACE = (4.0, 6.0)


def test_rays_of_the_other_finger_arrive_turned_about_y():
    out = np.array([[1.0, 2.0, 0.0, 0.0, -0.6, -0.8, 1, 2, 3], [1.9, 0, 0, -0.99, 0, -np.sqrt(1 - 0.99**2), 1, 1, 1]])
    found = arriving(out, 4.0, FACE, most=10)
    assert len(found) == 1  # the grazing one passes by
    assert found[0] == pytest.approx([-1, 2, -4, 0, -0.6, 0.8, 1, 2, 3], abs=2e-3)


def test_fewer_rays_carry_the_flux_of_all():
    random = np.random.default_rng(0)
    rays = np.zeros((1000, 9))
    rays[:, 0], rays[:, 1], rays[:, 5] = random.uniform(-2, 2, 1000), random.uniform(-3, 3, 1000), -1
    rays[:, 6:9] = random.uniform(0, 1, (1000, 3))
    found = arriving(rays, 3.0, FACE, most=300)
    assert len(found) <= 300
    np.testing.assert_allclose(found[:, 6:9].sum(0), rays[:, 6:9].sum(0), rtol=0.1)
