"""Both factorisations agree and notice matrices that are not positive definite."""

import numpy as np
import pytest
import scipy.sparse as sp

from magicsim.deform.solve.factorise import SuperluCondenser, SuperluSolver
from magicsim.deform.solve.pardiso import PardisoCondenser, PardisoSolver, has_pardiso

CONDENSERS = [SuperluCondenser, *([PardisoCondenser] if has_pardiso() else [])]
SOLVERS = [SuperluSolver, *([PardisoSolver] if has_pardiso() else [])]


def upper_laplacian(shift: float) -> sp.csr_matrix:
    matrix = sp.diags_array([-np.ones(29), np.full(30, 2.0 + shift), -np.ones(29)], offsets=[-1, 0, 1])
    return sp.csr_matrix(sp.triu(matrix))


@pytest.mark.parametrize("solver_type", SOLVERS)
def test_solver_inverts_and_refactorises(solver_type: type) -> None:
    matrix = upper_laplacian(0.5)
    solver = solver_type(matrix.indptr, matrix.indices)
    for factor in (1.0, 3.0):
        assert solver.factorise(factor * matrix.data)
        full = factor * (matrix + sp.triu(matrix, 1).T)
        np.testing.assert_allclose(full @ solver.solve(np.arange(30.0)), np.arange(30.0), atol=1e-12)


@pytest.mark.parametrize("solver_type", SOLVERS)
def test_solver_reports_an_indefinite_matrix_and_recovers(solver_type: type) -> None:
    matrix = upper_laplacian(0.0)
    solver = solver_type(matrix.indptr, matrix.indices)
    assert not solver.factorise(upper_laplacian(-1.0).data)
    assert solver.factorise(matrix.data)


@pytest.mark.parametrize("condenser_type", CONDENSERS)
def test_condenser_gives_the_schur_complement_and_the_whole_solution(condenser_type: type) -> None:
    matrix, kept, right = upper_laplacian(0.5), np.array([3, 4, 17, 29]), np.linspace(-1, 2, 30)
    full = (matrix + sp.triu(matrix, 1).T).toarray()
    rest = np.setdiff1d(np.arange(30), kept)
    exact = full[np.ix_(kept, kept)] - full[np.ix_(kept, rest)] @ np.linalg.solve(
        full[np.ix_(rest, rest)], full[np.ix_(rest, kept)]
    )
    condenser = condenser_type(matrix.indptr, matrix.indices, kept)
    for factor in (1.0, 3.0):
        schur = condenser.factorise(factor * matrix.data)
        assert schur is not None
        np.testing.assert_allclose(schur, factor * exact, atol=1e-12)
        reduced = condenser.reduce(right)
        motion = np.linalg.solve(schur, reduced[kept])
        np.testing.assert_allclose(factor * full @ condenser.expand(reduced, motion), right, atol=1e-12)


@pytest.mark.parametrize("condenser_type", CONDENSERS)
def test_reduced_forces_are_linear_and_know_what_the_eliminated_part_yields(condenser_type: type) -> None:
    matrix, kept = upper_laplacian(0.5), np.array([3, 4, 17, 29])
    full = (matrix + sp.triu(matrix, 1).T).toarray()
    rest = np.setdiff1d(np.arange(30), kept)
    condenser = condenser_type(matrix.indptr, matrix.indices, kept)
    condenser.factorise(matrix.data)
    first, second = np.linspace(-1, 2, 30), np.cos(np.arange(30.0))
    on_kept = np.zeros(30)
    on_kept[kept] = [1.0, -2.0, 0.5, 3.0]
    summed = 2 * condenser.reduce(first) + condenser.lifted(on_kept[kept])
    np.testing.assert_allclose(summed, condenser.reduce(2 * first + on_kept), atol=1e-12)
    expected = first[rest] @ np.linalg.solve(full[np.ix_(rest, rest)], second[rest])
    assert condenser.inner(condenser.reduce(first), condenser.reduce(second)) == pytest.approx(expected, abs=1e-12)


@pytest.mark.skipif(not has_pardiso(), reason="single precision is PARDISO's")
def test_a_factor_of_single_precision_keeps_the_kept_forces_exact() -> None:
    matrix, kept = upper_laplacian(0.5), np.array([3, 4, 17, 29])
    single, double = (PardisoCondenser(matrix.indptr, matrix.indices, kept, is_single=each) for each in (True, False))
    for condenser in (single, double):
        condenser.factorise(matrix.data)
    small, large = 1e-9 * np.cos(np.arange(30.0)), np.zeros(30)
    large[kept] = 1.0
    found, expected = (condenser.reduce(small + large)[kept] - 1.0 for condenser in (single, double))
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-15)


@pytest.mark.parametrize("condenser_type", CONDENSERS)
def test_condenser_reports_an_indefinite_eliminated_part_and_recovers(condenser_type: type) -> None:
    matrix = upper_laplacian(0.0)
    condenser = condenser_type(matrix.indptr, matrix.indices, np.array([0, 1]))
    assert condenser.factorise(upper_laplacian(-1.0).data) is None
    assert condenser.factorise(matrix.data) is not None


@pytest.mark.parametrize("condenser_type", CONDENSERS)
def test_condenser_hands_out_an_indefinite_complement_of_a_definite_eliminated_part(condenser_type: type) -> None:
    matrix, kept = upper_laplacian(0.5), np.array([3, 4, 17, 29])
    definite = condenser_type(matrix.indptr, matrix.indices, kept).factorise(matrix.data)
    assert definite is not None
    softened = matrix.data.copy()
    softened[matrix.indptr[kept]] -= 3.0
    condenser = condenser_type(matrix.indptr, matrix.indices, kept)
    schur = condenser.factorise(softened)
    assert schur is not None
    assert np.linalg.eigvalsh(schur)[0] < 0
    np.testing.assert_allclose(schur, definite - 3.0 * np.eye(4), atol=1e-12)
