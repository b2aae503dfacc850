"""Which contact points touch where a face waves."""

import numpy as np

from magicsim.deform.contact.face import contact_face
from magicsim.deform.deformation import BORDER, WAVE_MM, border_gaps_mm, touching_points
from magicsim.deform.lattice.structure import box_lattice

PLANES = np.linspace(-3, 3, 7)
LATTICE = box_lattice((PLANES, PLANES, np.linspace(0, 3, 4)), shear_modulus_mpa=1.0, lame_mpa=10.0)
FACE = contact_face(LATTICE)
POINTS = FACE.positions(LATTICE.nodes_mm)


def touching(gap: np.ndarray) -> np.ndarray:
    return touching_points(LATTICE, FACE, POINTS, gap, gap_limits_mm=0.002)


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


def test_border_of_a_round_contact_is_known_to_a_share_of_the_arc_over_a_facet() -> None:
    def gaps(radius: float) -> np.ndarray:
        away = POINTS - [0.0, 0.0, -radius]
        return border_gaps_mm(LATTICE, FACE, POINTS, away / np.linalg.norm(away, axis=1)[:, None])

    np.testing.assert_allclose(gaps(40.0), BORDER / (8 * 40.0), rtol=0.02)
    assert (gaps(1.0)[np.hypot(*POINTS[:, :2].T) < 0.5] == 0).all()  # turns too far over a facet of 1 mm


def test_flat_faces_and_edges_have_no_border_gap() -> None:
    up, side = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    flat = np.tile(up, (len(POINTS), 1))
    assert (border_gaps_mm(LATTICE, FACE, POINTS, flat) == 0).all()
    edge = np.where(POINTS[:, :1] < 0.5, up, side)
    assert (border_gaps_mm(LATTICE, FACE, POINTS, edge) == 0).all()
