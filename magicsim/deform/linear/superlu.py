"""SciPy's SuperLU, where MKL PARDISO is not available: the same factors, several times slower."""

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from magicsim.arrays import Array, Index, Indices


class SuperluSolver:
    """SciPy's SuperLU without pivoting, so that the signs of the pivots tell definiteness."""

    def __init__(self, indptr: Indices, indices: Indices) -> None:
        """Takes the pattern; see `linear.symmetric_solver`."""
        self._pattern = (indices, indptr)
        self._size = len(indptr) - 1
        self._factor: Any = None

    def factorise(self, values: Array) -> bool:
        """See `linear.SymmetricSolver.factorise`."""
        upper = sp.csr_matrix((values, *self._pattern), shape=(self._size,) * 2)
        self._factor = _definite_factor((upper + sp.triu(upper, 1).T).tocsc())
        return self._factor is not None

    def solve(self, right: Array) -> Array:
        """See `linear.SymmetricSolver.solve`."""
        return np.asarray(self._factor.solve(right), dtype=np.float64)


class SuperluCondenser:
    """SuperLU that eliminates all unknowns but some.

    Reduced forces are twice as long as forces: condensed ones and the motion of the others while the kept ones do not
    move, then the forces themselves.
    """

    def __init__(self, indptr: Indices, indices: Indices, kept: Index) -> None:
        """Takes the pattern, see `linear.symmetric_solver`, and the unknowns that are kept, ascending."""
        self.kept = kept
        self._pattern = (indices, indptr)
        self._size = len(indptr) - 1
        self._interior = np.setdiff1d(np.arange(self._size), kept)
        self._factor: Any = None
        self._coupling: Any = None
        self._followed = np.empty((0, 0))

    def factorise(self, values: Array) -> Array | None:
        """See `linear.SymmetricCondenser.factorise`."""
        upper = sp.csr_matrix((values, *self._pattern), shape=(self._size,) * 2)
        full = (upper + sp.triu(upper, 1).T).tocsr()
        rows = full[self._interior]
        self._factor = _definite_factor(rows[:, self._interior].tocsc())
        if self._factor is None:
            return None
        self._coupling = rows[:, self.kept].tocsc()
        self._followed = np.asarray(self._factor.solve(self._coupling.toarray()))
        schur = full[self.kept][:, self.kept].toarray() - self._coupling.T @ self._followed
        return np.asarray((schur + schur.T) / 2)

    def reduce(self, forces: Array) -> Array:
        """See `linear.SymmetricCondenser.reduce`."""
        found = np.concatenate([forces, forces])
        found[self._interior] = self._factor.solve(forces[self._interior])
        found[self.kept] -= self._coupling.T @ found[self._interior]
        return found

    def lifted(self, forces: Array) -> Array:
        """See `linear.SymmetricCondenser.lifted`."""
        found = np.zeros(2 * self._size)
        found[self.kept] = found[self._size + self.kept] = forces
        return found

    def inner(self, first: Array, second: Array) -> Array:
        """See `linear.SymmetricCondenser.inner`."""
        return np.asarray(first[self._size + self._interior].T @ second[self._interior])

    def expand(self, reduced: Array, motion: Array) -> Array:
        """See `linear.SymmetricCondenser.expand`."""
        found = reduced[: self._size].copy()
        found[self.kept] = motion
        found[self._interior] -= self._followed @ motion
        return found


def _definite_factor(matrix: sp.csc_matrix) -> Any:  # noqa: ANN401
    """SuperLU's object; None where the matrix is not positive definite."""
    options = {"SymmetricMode": True}
    try:
        factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return None
    return factor if (factor.U.diagonal() > 0).all() else None
