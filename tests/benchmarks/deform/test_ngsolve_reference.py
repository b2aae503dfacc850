"""The reference's mesh, and the reference against the lattice on a small block."""

import numpy as np
import pytest

pytest.importorskip("ngsolve")

from laboratory.deform.methods import graded_quarter, solve_lattice
from laboratory.deform.ngsolve_reference import graded_axis, solve_ngsolve
from laboratory.deform.problem import Observation, sphere_on_block


@pytest.mark.parametrize("length", [3.0, 12.0, 16.0])
def test_axis_is_even_in_the_zone_and_grows_to_the_edge(length):
    axis = graded_axis(8, 2.0, length)
    np.testing.assert_allclose(np.diff(axis)[:8], 0.25)
    assert axis[-1] == pytest.approx(length)
    assert (np.diff(axis)[8:] > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("modulus_mpa", [10.0, 100.0])
def test_coated_block_is_as_stiff_as_that_of_the_reference(modulus_mpa):
    coat = f"coat={{kind='opaque',thickness_mm=0.05,modulus_mpa={modulus_mpa}}}"
    problem = sphere_on_block("footprint_mm=[6.0, 6.0]", "core_mm=3.0", coat).down_to(0.5)
    (reference,) = solve_ngsolve(problem, 1, elements=4, order=2)
    (own,) = solve_lattice(problem, 1, spacing_mm=0.5, tolerance_mm=0.002, build=graded_quarter)
    assert own.force_n == pytest.approx(reference.force_n, rel=0.01)


@pytest.mark.slow
def test_lattice_approaches_the_reference_on_a_small_block():
    problem = sphere_on_block("footprint_mm=[6.0, 6.0]", "core_mm=3.0").down_to(0.5)
    (reference,) = solve_ngsolve(problem, 1, elements=4, order=2)
    assert isinstance(reference, Observation)
    assert reference.surface_mm[0] == pytest.approx([0, 0, 0.5], abs=1e-3)
    errors = []
    for spacing in (1.0, 0.5):
        (own,) = solve_lattice(problem, 1, spacing_mm=spacing, tolerance_mm=0.002)
        errors.append(np.sqrt(((own.surface_mm - reference.surface_mm) ** 2).sum(1).mean()))
    assert own.force_n == pytest.approx(reference.force_n, rel=0.01)
    assert errors[1] < 0.6 * errors[0]
