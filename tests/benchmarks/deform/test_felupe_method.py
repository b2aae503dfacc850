"""The contact written for felupe, and felupe against the lattice on a small block."""

import numpy as np
import pytest

felupe = pytest.importorskip("felupe")

from laboratory.deform.felupe_method import SphereContact, solve_felupe  # noqa: E402
from laboratory.deform.methods import solve_lattice  # noqa: E402
from laboratory.deform.problem import Observation, sphere_on_block  # noqa: E402

SMALL = sphere_on_block("footprint_mm=[6.0, 6.0]", "core_mm=3.0").down_to(0.25, 0.5)


def pressed_contact() -> SphereContact:
    mesh = felupe.Cube(a=(0, 0, 0), b=(2, 2, 1), n=(5, 5, 3))
    field = felupe.FieldContainer([felupe.Field(felupe.RegionHexahedron(mesh), dim=3)])
    face = felupe.RegionHexahedronBoundary(mesh, mask=np.isclose(mesh.points[:, 2], 0), only_surface=True)
    contact = SphereContact(field, face, radius_mm=2.0, penalty=30.0)
    contact.depth_mm = 0.3
    field[0].values[:] = 0.02 * np.random.default_rng(0).normal(size=mesh.points.shape)
    return contact


def test_contact_matrix_is_the_derivative_of_its_vector():
    contact = pressed_contact()
    values, step = contact.field[0].values, 1e-6
    direction = np.random.default_rng(1).normal(size=values.shape)
    exact = contact.assemble.matrix() @ direction.ravel()
    numeric = np.zeros_like(exact)
    for sign in (1, -1):
        values += sign * step * direction
        numeric += sign * contact.assemble.vector().toarray()[:, 0] / (2 * step)
        values -= sign * step * direction
    np.testing.assert_allclose(numeric, exact, atol=1e-6 * np.abs(exact).max())


def test_contact_force_is_the_sum_of_its_vector():
    contact = pressed_contact()
    total = contact.assemble.vector().toarray().reshape(-1, 3).sum(0)
    np.testing.assert_allclose(contact.force_n, -total, rtol=1e-12)


def test_quarter_and_whole_block_agree():
    quarter, whole = (list(solve_felupe(SMALL, 1, element_mm=1.0, whole=whole)) for whole in (False, True))
    for first, second in zip(quarter, whole, strict=True):
        assert isinstance(first, Observation)
        assert isinstance(second, Observation)
        assert first.force_n == pytest.approx(second.force_n, rel=1e-6)
        assert first.contact_area_mm2 == pytest.approx(second.contact_area_mm2, rel=1e-6)
        np.testing.assert_allclose(first.surface_mm, second.surface_mm, atol=1e-6)


def test_repeats_start_from_the_same_state():
    once, thrice = (list(solve_felupe(SMALL, repeats, element_mm=1.0)) for repeats in (1, 3))
    assert [len(outcome.seconds) for outcome in thrice] == [3, 3]
    for first, second in zip(once, thrice, strict=True):
        assert first.force_n == pytest.approx(second.force_n, rel=1e-9)


@pytest.mark.slow
def test_felupe_and_lattice_approach_each_other():
    differences = []
    for size in (1.0, 0.5):
        independent = list(solve_felupe(SMALL, 1, element_mm=size))[-1]
        own = list(solve_lattice(SMALL, 1, spacing_mm=size, tolerance_mm=0.002))[-1]
        differences.append(abs(own.force_n / independent.force_n - 1))
    assert differences[1] < 0.6 * differences[0]
    assert differences[1] < 0.04
