"""A large face's matrix with its untouched nodes eliminated."""

import numpy as np
import pytest

from magicsim.deform.contact.augmented import add_dense_stiffness
from magicsim.deform.contact.face import ContactFace, contact_face
from magicsim.deform.lattice.structure import box_lattice
from magicsim.deform.solve.face_part import FacePart, TouchedMatrix, is_large


@pytest.fixture
def face() -> ContactFace:
    planes = np.linspace(0, 8, 9)
    whole = contact_face(box_lattice((planes, planes, planes), shear_modulus_mpa=1.0, lame_mpa=10.0))
    return FacePart.of(whole, np.arange(64)).face


def stiff(face: ContactFace, seed: int = 1) -> np.ndarray:
    size = 3 * (face.patches.max() + 1)
    square = np.random.default_rng(seed).normal(size=(size, size))
    return np.asarray(square @ square.T + np.eye(size))


def contact(face: ContactFace, facets: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Points on some facets and a stiffness along a normal for each."""
    acting = np.flatnonzero(np.isin(face.facet, facets))
    normal = np.random.default_rng(2).normal(size=(len(acting), 3))
    return acting, 50.0 * normal[:, :, None] * normal[:, None, :]


def test_solution_is_that_of_the_whole_matrix_whatever_was_eliminated_before(face: ContactFace) -> None:
    stiffness = stiff(face)
    held = np.zeros(len(stiffness), bool)
    held[[4, 100]] = True
    stiffness[held], stiffness[:, held] = 0.0, 0.0
    stiffness[held, held] = 1.0
    right = np.where(held, 0.0, np.random.default_rng(3).normal(size=len(stiffness)))
    matrix = TouchedMatrix(stiffness, held)
    for facets in ([18, 19, 26, 27], [19], [5], [], list(range(64))):
        acting, local = contact(face, facets)
        whole = stiffness.copy()
        add_dense_stiffness(whole, face, acting, local)
        whole[held], whole[:, held] = 0.0, 0.0
        whole[held, held] = 1.0
        found = matrix.solve(face, acting, local, right)
        assert found is not None
        np.testing.assert_allclose(found, np.linalg.solve(whole, right), atol=1e-9)
        np.testing.assert_array_equal(found[held], 0.0)


def test_matrices_that_are_not_definite_are_refused(face: ContactFace) -> None:
    acting, local = contact(face, [18, 19])
    touched = np.unique(face.patches[[18, 19]])
    for node in (touched[0], np.setdiff1d(face.patches, touched)[0]):
        stiffness = stiff(face)
        stiffness[3 * node, 3 * node] -= 1e6
        held = np.zeros(len(stiffness), bool)
        assert TouchedMatrix(stiffness, held).solve(face, acting, 1e-3 * local, np.ones(len(stiffness))) is None


def test_a_face_is_large_by_the_unknowns_that_move_its_facets(face: ContactFace) -> None:
    assert not is_large(face, np.arange(64))
    planes = np.linspace(0, 20, 21)
    wide = contact_face(box_lattice((planes, planes, planes[:3]), shear_modulus_mpa=1.0, lame_mpa=10.0))
    assert is_large(wide, np.arange(len(wide.patches)))
