"""Both factorisations agree and notice matrices that are not positive definite."""

import numpy as np
import pytest
import scipy.sparse as sp

from magicsim.deform.linear import PardisoSolver, SuperluSolver, has_pardiso

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
