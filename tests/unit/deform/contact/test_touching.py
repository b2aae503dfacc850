"""Which contact points touch where a face waves."""

import numpy as np

from magicsim.deform.contact.face import contact_face
from magicsim.deform.contact.touching import WAVE_MM, touching_points
from magicsim.deform.lattice.structure import box_lattice

PLANES = np.linspace(-3, 3, 7)
LATTICE = box_lattice((PLANES, PLANES, np.linspace(0, 3, 4)), shear_modulus_mpa=1.0, lame_mpa=10.0)
FACE = contact_face(LATTICE)
POINTS = FACE.positions(LATTICE.nodes_mm)


def touching(gap: np.ndarray) -> np.ndarray:
    return touching_points(LATTICE, FACE, POINTS, gap, gap_limit_mm=0.002)


def test_a_wave_between_points_that_touch_is_bridged() -> None:
    inside = (np.abs(POINTS[:, :2]) < 2).all(1)
    waves = WAVE_MM / 2 * (1 + np.cos(2 * np.pi * POINTS[:, 0]))
    found = touching(np.where(inside, waves, 0.5))
    deep = (np.abs(POINTS[:, :2]) < 1.4).all(1)
    assert found[deep].all()
    assert not found[~inside].any()


def test_nothing_is_bridged_beside_a_round_contact_nor_over_a_wide_gap() -> None:
    radius = np.hypot(*POINTS[:, :2].T)
    gap = np.where(radius < 1.5, 0.0, 0.015)
    found = touching(gap)
    assert found[radius < 1.5].all()
    assert not found[radius > 1.9].any()
    hole = np.where(radius < 0.5, 2 * WAVE_MM, 0.0)
    assert not touching(hole)[radius < 0.5].any()
