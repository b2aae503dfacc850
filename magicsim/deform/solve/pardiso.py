"""MKL PARDISO: factors of symmetric positive definite matrices, whole or without some unknowns.

The same numbers must come out in every process, whatever the number of cores or `OMP_NUM_THREADS`: MKL runs in its
conditional numerical reproducibility mode and plans for a thread count that is fixed here. Fewer threads then give the
same bits, so that a process that was told to use one does not take a core from its neighbour.
"""

import ctypes
import importlib
import logging
import os
import weakref
from collections.abc import Sequence
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Indices
from magicsim.folder import check_current_folder

THREADS = 2
"""MKL threads that PARDISO plans for, fixed so that results do not depend on how many run it; never more run it."""
CBWR_AUTO_STRICT = 2
"""MKL_CBWR_AUTO of mkl_service.h: one code path, the best for this processor."""
ANALYSE_TOO, FACTORISE, SOLVE, FORWARD, BACKWARD, RELEASE = 12, 22, 33, 331, 333, -1
"""Phases of PARDISO: analysis and factorisation, factorisation, solution, its halves beside a Schur complement, and the
end."""
POSITIVE_DEFINITE = 2
"""PARDISO's matrix type `real symmetric positive definite`."""
HOLDING = 10.0
"""Stiffness that holds the kept unknowns in units of their largest one."""
LIBRARY_VARIABLE = "PYPARDISO_MKL_RT"
WAITING_VARIABLE = "KMP_BLOCKTIME"
"""Milliseconds for which MKL's idle threads spin after a call, 200 unless it is set: on cores that others need."""
LOGGER = logging.getLogger(__name__)


@lru_cache(maxsize=1)
def has_pardiso() -> bool:
    """Whether MKL PARDISO can be loaded; sets its reproducibility mode before anything else calls it.

    Says where MKL is, in the variable that pypardiso and child processes look at: every one of pypardiso's solvers
    would search the whole environment's folders for it.
    """
    check_current_folder()
    os.environ.setdefault(WAITING_VARIABLE, "0")
    files = (file for package in metadata.distributions(name="mkl") for file in package.files or ())
    if library := next((file for file in files if "mkl_rt" in file.name), None):
        os.environ.setdefault(LIBRARY_VARIABLE, str(Path(str(library.locate())).resolve()))
    try:
        solver = importlib.import_module("pypardiso").PyPardisoSolver()
    except (ImportError, OSError):
        LOGGER.info("pypardiso is not available: using SciPy's SuperLU, several times slower")
        return False
    if solver.libmkl.MKL_CBWR_Set(CBWR_AUTO_STRICT) != 0:
        LOGGER.warning("MKL was in use before: displacements may differ in the last bits from run to run")
    solver.libmkl.MKL_Set_Dynamic(0)
    return True


class PardisoSolver:
    """MKL PARDISO; the symbolic analysis is done once."""

    def __init__(
        self, indptr: Indices, indices: Indices, *, kept: Index | None = None, is_single: bool = False
    ) -> None:
        """Takes the pattern of an upper triangle: row starts, shape (size + 1,), and ascending columns.

        Of unknowns that are kept, ascending, `call` hands out the Schur complement. A factor of single precision takes
        half of the time and memory.
        """
        module = importlib.import_module("pypardiso")
        self._library = module.PyPardisoSolver().libmkl
        self.size = len(indptr) - 1
        self._type = np.float32 if is_single else np.float64
        self._indptr, self._indices = (np.array(part, np.int32) for part in (indptr, indices))
        self._values = np.zeros(len(indices), self._type)
        self._kept = np.zeros(self.size, np.int32)
        self._handle = np.zeros(64, np.int64)
        self._options = np.zeros(64, np.int32)
        # Numbered as in MKL's manual: own values, METIS, no refinement, pivots, one-level, precision, reproducible
        # threads, counted from zero, Schur complement.
        options = ((1, 1), (2, 2), (8, 0), (10, 8), (24, 0), (28, int(is_single)), (34, THREADS), (35, 1))
        for number, value in options:
            self._options[number - 1] = value
        if kept is not None:
            self._options[35], self._kept[kept] = 2, 1
        self._is_analysed = False
        self._threads = min(THREADS, self._library.MKL_Get_Max_Threads())
        # Python does not see the factor's memory.
        self._release = weakref.finalize(self, _release, self._library, self._handle, self._options, self.size)
        self._release.atexit = False

    def factorise(self, values: Array) -> bool:
        """Takes the upper triangle's entries; False when the matrix is not positive definite."""
        return self.call(FACTORISE, np.zeros(self.size), values) is not None

    def solve(self, right: Array) -> Array:
        """Solution for one right-hand side, shape (size,), with the last factor."""
        result = self.call(SOLVE, right)
        if result is None:
            raise RuntimeError("PARDISO has no factor to solve with")
        return result

    def call(self, phase: int, right: Array, values: Array | None = None) -> Array | None:
        """What PARDISO wrote, as long as the right-hand side; None where it failed. Values are those of a new matrix.

        Phases are those of MKL's manual; a first factorisation is preceded by the analysis.
        """
        if values is not None:
            self._values = np.ascontiguousarray(values, dtype=self._type)
        given = np.ascontiguousarray(right, dtype=self._type)
        result = np.zeros_like(given)
        previous = self._library.MKL_Set_Num_Threads_Local(self._threads)
        try:
            whole = ANALYSE_TOO if phase == FACTORISE and not self._is_analysed else phase
            matrix = (self._values, self._indptr, self._indices, self._kept)
            error = _pardiso(self._library, self._handle, self._options, whole, self.size, matrix, (given, result))
            self._is_analysed = True
        finally:
            self._library.MKL_Set_Num_Threads_Local(previous)
        return np.asarray(result, np.float64) if error == 0 else None


def _pardiso(
    library: Any,  # noqa: ANN401
    handle: Index,
    options: Indices,
    phase: int,
    size: int,
    matrix: Sequence[npt.NDArray[Any]],
    sides: Sequence[npt.NDArray[Any]],
) -> int:
    """PARDISO's error; arguments as in MKL's manual, one matrix and one right-hand side."""
    error = ctypes.c_int32(0)

    def number(value: int) -> Any:  # noqa: ANN401
        return ctypes.byref(ctypes.c_int32(value))

    def place(array: npt.NDArray[Any]) -> Any:  # noqa: ANN401
        return array.ctypes.data_as(ctypes.c_void_p)

    values, indptr, indices, kept = (place(part) for part in matrix)
    function = library["pardiso"]  # another object than pypardiso's, which takes doubles only
    function.restype = None
    function(
        place(handle), number(1), number(1), number(POSITIVE_DEFINITE), number(phase), number(size), values, indptr,
        indices, kept, number(1), place(options), number(0), *(place(side) for side in sides), ctypes.byref(error),
    )  # fmt: skip
    return error.value


def _release(library: Any, handle: Index, options: Indices, size: int) -> None:  # noqa: ANN401
    nothing = np.zeros(1)
    none = np.zeros(1, np.int32)
    _pardiso(library, handle, options, RELEASE, size, (nothing, none, none, none), (nothing, nothing))


class PardisoCondenser:
    """MKL PARDISO that eliminates all unknowns but some: their Schur complement, and the two halves of a solution.

    PARDISO refuses a matrix whose Schur complement is indefinite, which says nothing against eliminating the others: a
    pressed body is often stable only because something holds it where it is pressed. So the kept unknowns are held
    while it works, by a stiffness that is taken off the complement again.
    """

    def __init__(self, indptr: Indices, indices: Indices, kept: Index, *, is_single: bool = False) -> None:
        """Takes the pattern and precision, see `PardisoSolver`, and the unknowns that are kept, ascending."""
        self.kept = kept
        self._diagonal = indptr[kept]
        self._plain = PardisoSolver(indptr, indices, kept=kept, is_single=is_single)

    def factorise(self, values: Array) -> Array | None:
        """Schur complement of the kept unknowns, shape (kept, kept); None where the others' block is not definite."""
        count, held = len(self.kept), values.copy()
        stiffness = HOLDING * float(np.abs(values[self._diagonal]).max())
        held[self._diagonal] += stiffness
        result = self._plain.call(FACTORISE, np.zeros(max(count * count, self._plain.size)), held)
        if result is None:
            return None
        schur = result[: count * count].reshape(count, count)
        schur[np.diag_indices(count)] -= stiffness
        return schur

    def reduce(self, forces: Array) -> Array:
        """Reduced form of forces, shape (size,), linear in them; `[kept]` of it are the condensed ones.

        The kept unknowns' own forces are added in double precision: near equilibrium they alone are large.
        """
        interior = forces.copy()
        interior[self.kept] = 0.0
        result = self._half(FORWARD, interior)
        result[self.kept] += forces[self.kept]
        return result

    def lifted(self, forces: Array) -> Array:
        """Reduced form of forces on the kept unknowns alone, shape (kept,)."""
        result = np.zeros(self._plain.size)
        result[self.kept] = forces
        return result

    def inner(self, first: Array, second: Array) -> Array:
        """f^T A^-1 g of the eliminated parts of reduced forces f, or some of them as columns, and g, A their block."""
        interior = second.copy()
        interior[self.kept] = 0.0
        return np.asarray(first.T @ interior)

    def expand(self, reduced: Array, motion: Array) -> Array:
        """Motion of all unknowns under reduced forces where the kept ones move as given, shape (size,)."""
        right = reduced.copy()
        right[self.kept] = motion
        result = self._half(BACKWARD, right)
        result[self.kept] = motion
        return result

    def _half(self, phase: int, right: Array) -> Array:
        result = self._plain.call(phase, right)
        if result is None:
            raise RuntimeError("PARDISO refused half of a solution")
        return result
