"""Factorise a symmetric positive definite matrix: MKL PARDISO where it exists, SciPy's SuperLU elsewhere.

What is asked of either is the same, so the algorithm does not depend on which there is.
"""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import ParamSpec, Protocol, TypeVar

from threadpoolctl import ThreadpoolController

from magicsim.arrays import Array, Index, Indices
from magicsim.deform.linear.pardiso import PardisoCondenser, PardisoSolver, has_pardiso
from magicsim.deform.linear.superlu import SuperluCondenser, SuperluSolver

P = ParamSpec("P")
T = TypeVar("T")


def on_one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Keeps NumPy's own BLAS on one thread while a function runs.

    Its sums would depend on the number of cores, and its idle threads would spin on those that MKL needs. Beside other
    work, factorisations of a few rows each (a triangulation's 600 took 3 s) wait for threads that do not get to run.
    """

    @wraps(function)
    def calm(*arguments: P.args, **named: P.kwargs) -> T:
        with _controller().select(internal_api="openblas").limit(limits=1):
            return function(*arguments, **named)

    return calm


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


class SymmetricSolver(Protocol):
    """Refactorises matrices of one sparsity pattern."""

    def factorise(self, values: Array) -> bool:
        """Takes the upper triangle's entries; False when the matrix is not positive definite."""

    def solve(self, right: Array) -> Array:
        """Solution for one right-hand side, shape (size,), with the last factor."""


class SymmetricCondenser(Protocol):
    """Eliminates all unknowns but some, which are kept, from matrices of one sparsity pattern.

    Forces on all unknowns are handed around in a reduced form of its own, a vector that is linear in them.
    """

    kept: Index
    """Unknowns that are kept, ascending, shape (kept,)."""

    def factorise(self, values: Array) -> Array | None:
        """Schur complement of the kept unknowns, shape (kept, kept); None where the others' block is not definite."""

    def reduce(self, forces: Array) -> Array:
        """Reduced form of forces, shape (size,); `[kept]` of it are the condensed forces on the kept unknowns."""

    def lifted(self, forces: Array) -> Array:
        """Reduced form of forces on the kept unknowns alone, shape (kept,)."""

    def inner(self, first: Array, second: Array) -> Array:
        """f^T A^-1 g of the eliminated parts f, g of reduced forces, A their block.

        Args:
            first: f, shape (size,), or some of them as columns.
            second: g, shape (size,).
        """

    def expand(self, reduced: Array, motion: Array) -> Array:
        """Motion of all unknowns under reduced forces where the kept ones move as given, shape (size,)."""


def symmetric_condenser(indptr: Indices, indices: Indices, kept: Index, *, is_single: bool) -> SymmetricCondenser:
    """The best condenser for this machine.

    Args:
        indptr: Row starts of the upper triangle, shape (size + 1,).
        indices: Ascending columns, shape (entries,).
        kept: Unknowns that are kept, ascending.
        is_single: Whether single precision will do.
    """
    if has_pardiso():
        return PardisoCondenser(indptr, indices, kept, is_single=is_single)
    return SuperluCondenser(indptr, indices, kept)


def symmetric_solver(indptr: Indices, indices: Indices) -> SymmetricSolver:
    """The best solver for this machine.

    Args:
        indptr: Row starts of the upper triangle, shape (size + 1,).
        indices: Ascending columns, shape (entries,).
    """
    return PardisoSolver(indptr, indices) if has_pardiso() else SuperluSolver(indptr, indices)
