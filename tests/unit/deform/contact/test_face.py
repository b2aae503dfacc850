"""The contact face follows its nodes without overshooting, whatever the planes."""

import numpy as np
import pytest

from magicsim.deform.contact.face import ContactFace, contact_face, face_weights
from magicsim.deform.lattice.structure import Lattice, box_lattice

REGULAR = np.linspace(0.0, 3.0, 7)
WALLS = np.array([0.0, 0.4, 0.5, 0.6, 1.0, 1.4, 1.5, 2.5, 5.0])
"""As beside printed walls: a factor of ten between neighbouring spacings."""


def block(planes: np.ndarray) -> Lattice:
    return box_lattice((planes, planes, np.array([0.0, 1.0])), shear_modulus_mpa=1.0, lame_mpa=10.0)


def height(face: ContactFace, lattice: Lattice, power: int) -> tuple[np.ndarray, np.ndarray]:
    """Interpolated and true values of (x + 2 y)^power at the points."""
    nodes = lattice.nodes_mm.copy()
    nodes[:, 2] = (nodes[:, 0] + 2 * nodes[:, 1]) ** power
    points = face.positions(nodes)
    return points[:, 2], (points[:, 0] + 2 * points[:, 1]) ** power


@pytest.mark.parametrize(("planes", "exact"), [(REGULAR, 3), (WALLS, 1)])
def test_polynomials_are_followed_exactly(planes: np.ndarray, exact: int) -> None:
    lattice = block(planes)
    face = contact_face(lattice)
    for power in range(exact + 1):
        found, true = height(face, lattice, power)
        np.testing.assert_allclose(found, true, atol=1e-10)


@pytest.mark.parametrize("planes", [REGULAR, WALLS])
def test_no_node_moves_the_face_further_than_itself(planes: np.ndarray) -> None:
    """One cubic through the planes beside walls would have weights of 3.9, and their sizes would add up to 11."""
    face = contact_face(block(planes))
    assert np.abs(face.shape).max() < 1.25
    assert np.abs(face.shape).sum(1).max() < 3


@pytest.mark.parametrize("planes", [REGULAR, WALLS])
def test_tangents_are_the_derivatives(planes: np.ndarray) -> None:
    lattice = block(planes)
    face = contact_face(lattice)
    nodes = lattice.nodes_mm[face.patches[face.facet]][..., :2]
    tangents = np.einsum("qad,qai->qdi", face.slopes, nodes)
    np.testing.assert_allclose(tangents, np.broadcast_to(np.eye(2), tangents.shape), atol=1e-10)


@pytest.mark.parametrize("planes", [REGULAR, WALLS])
def test_any_place_of_the_face_moves_as_the_contact_points_there(planes: np.ndarray) -> None:
    lattice = block(planes)
    face = contact_face(lattice)
    moved = np.random.default_rng(3).normal(size=lattice.nodes_mm.shape)
    weights = face_weights(lattice, face.positions(lattice.nodes_mm)[:, :2])
    np.testing.assert_allclose(weights @ moved, face.positions(moved), atol=1e-12)
    corners = face_weights(lattice, np.array([[-1.0, 0.0], [9.0, 9.0]])) @ moved
    np.testing.assert_allclose(corners, moved[[0, len(planes) ** 2 - 1]], atol=1e-12)


def test_two_planes_are_interpolated_linearly() -> None:
    lattice = block(np.array([0.0, 1.0]))
    found, true = height(contact_face(lattice), lattice, 1)
    np.testing.assert_allclose(found, true, atol=1e-12)
