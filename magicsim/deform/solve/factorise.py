"""Factorise a symmetric positive definite matrix: MKL PARDISO where it exists, SciPy's SuperLU elsewhere.

What is asked of either is the same, so the algorithm does not depend on which there is.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from threadpoolctl import ThreadpoolController

from magicsim.arrays import Array, Index, Indices
from magicsim.deform.solve.pardiso import PardisoCondenser, PardisoSolver, has_pardiso


class SuperluSolver:
    """SciPy's SuperLU without pivoting, so that the signs of the pivots tell definiteness."""

    def __init__(self, indptr: Indices, indices: Indices) -> None:
        self._pattern = (indices, indptr)
        self._factor: Any = None

    def factorise(self, values: Array) -> bool:
        """See `PardisoSolver.factorise`."""
        self._factor = _definite_factor(_whole(values, self._pattern).tocsc())
        return self._factor is not None

    def solve(self, right: Array) -> Array:
        """See `PardisoSolver.solve`."""
        return np.asarray(self._factor.solve(right), dtype=np.float64)


class SuperluCondenser:
    """SuperLU that eliminates all unknowns but some.

    Reduced forces are twice as long as forces: condensed ones and the motion of the others while the kept ones do not
    move, then the forces themselves.
    """

    def __init__(self, indptr: Indices, indices: Indices, kept: Index) -> None:
        """Takes the pattern, see `PardisoSolver`, and the unknowns that are kept, ascending."""
        self.kept = kept
        self._pattern = (indices, indptr)
        self._size = len(indptr) - 1
        self._interior = np.setdiff1d(np.arange(self._size), kept)
        self._factor: Any = None
        self._coupling: Any = None
        self._followed = np.empty((0, 0))

    def factorise(self, values: Array) -> Array | None:
        """See `PardisoCondenser.factorise`."""
        full = _whole(values, self._pattern).tocsr()
        rows = full[self._interior]
        self._factor = _definite_factor(rows[:, self._interior].tocsc())
        if self._factor is None:
            return None
        self._coupling = rows[:, self.kept].tocsc()
        self._followed = np.asarray(self._factor.solve(self._coupling.toarray()))
        schur = full[self.kept][:, self.kept].toarray() - self._coupling.T @ self._followed
        return np.asarray((schur + schur.T) / 2)

    def reduce(self, forces: Array) -> Array:
        """See `PardisoCondenser.reduce`."""
        result = np.concatenate([forces, forces])
        result[self._interior] = self._factor.solve(forces[self._interior])
        result[self.kept] -= self._coupling.T @ result[self._interior]
        return result

    def lifted(self, forces: Array) -> Array:
        """See `PardisoCondenser.lifted`."""
        result = np.zeros(2 * self._size)
        result[self.kept] = result[self._size + self.kept] = forces
        return result

    def inner(self, first: Array, second: Array) -> Array:
        """See `PardisoCondenser.inner`."""
        return np.asarray(first[self._size + self._interior].T @ second[self._interior])

    def expand(self, reduced: Array, motion: Array) -> Array:
        """See `PardisoCondenser.expand`."""
        result = reduced[: self._size].copy()
        result[self.kept] = motion
        result[self._interior] -= self._followed @ motion
        return result


def _whole(values: Array, pattern: tuple[Indices, Indices]) -> sp.csr_matrix:
    """The symmetric matrix of an upper triangle: its entries, and their columns and row starts."""
    upper = sp.csr_matrix((values, *pattern), shape=(len(pattern[1]) - 1,) * 2)
    return upper + sp.triu(upper, 1).T


def _definite_factor(matrix: sp.csc_matrix) -> Any:  # noqa: ANN401
    """SuperLU's object; None where the matrix is not positive definite."""
    options = {"SymmetricMode": True}
    try:
        factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return None
    return factor if (factor.U.diagonal() > 0).all() else None


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def _one_blas_thread() -> Iterator[None]:
    with _controller().select(internal_api="openblas").limit(limits=1):
        yield


on_one_blas_thread = _one_blas_thread()
"""Decorates a function: NumPy's own BLAS has one thread while it runs.

Its sums would depend on the number of cores, and its idle threads would spin on those that MKL needs. Beside other
work, factorisations of a few rows each (a triangulation's 600 took 3 s) wait for threads that do not get to run.
"""


SymmetricSolver = PardisoSolver | SuperluSolver
"""Refactorises matrices of one sparsity pattern."""
SymmetricCondenser = PardisoCondenser | SuperluCondenser
"""Eliminates all unknowns but some from matrices of one sparsity pattern."""


def symmetric_condenser(indptr: Indices, indices: Indices, kept: Index, *, is_single: bool) -> SymmetricCondenser:
    """The best condenser for this machine; arguments are those of `PardisoSolver`."""
    if has_pardiso():
        return PardisoCondenser(indptr, indices, kept, is_single=is_single)
    return SuperluCondenser(indptr, indices, kept)


def symmetric_solver(indptr: Indices, indices: Indices) -> SymmetricSolver:
    """The best solver for this machine, for the upper triangle of a pattern in compressed rows."""
    return PardisoSolver(indptr, indices) if has_pardiso() else SuperluSolver(indptr, indices)
