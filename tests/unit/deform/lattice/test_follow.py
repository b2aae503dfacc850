"""Points follow the lattice exactly for affine fields."""

import numpy as np

from magicsim.deform.lattice.follow import follow_map
from magicsim.deform.lattice.structure import box_lattice

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
