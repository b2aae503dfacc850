"""The body as the face feels it: its stiffness at one state, condensed, and what later states taught about it.

Factorising is most of what an equilibrium costs, and the stiffness of the body changes little from one state of a path
to the next. So it is factorised where that was last worth it (a `Linearisation`), and what has changed since is learned
from the steps themselves. A step s from the model K is meant to leave the forces K s behind; what the gradient of the
energy leaves instead, e = dg - K s, corrects the model,

    K <- K + e e^T / (e^T s),

the symmetric rank-one formula (Nocedal and Wright 2006, 6.2). On a quadratic energy all earlier steps stay exact, so
iterations converge like a Krylov method with the old factor as its preconditioner. Contact has no part in it: it is
solved in full on the model, and e is smooth in the state.

With interior unknowns i eliminated and E the columns e, D = diag(e^T s), the condensed model is

    S = S_0 + R M R^T,   y = y_0 - R M h,   M = (D + E_i^T K_ii^-1 E_i)^-1,

R being the condensed E and h = E_i^T K_ii^-1 r_i for forces r: products of halves of solutions that every step computes
anyway. A correction that softens (e^T s < 0) is taken only where the body, held by the object, stays well stable.

A solver holds one factor. What a solve comes to depends on its path alone: a factor is a function of its
`Linearisation`, which the states of a path carry, and is made again where the solver holds another one.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.solve.face_part import FacePart
from magicsim.deform.solve.factorise import SymmetricCondenser, symmetric_condenser
from magicsim.deform.solve.iterate import Iterate
from magicsim.deform.solve.problem import Problem

# Numbers without a source are assumed: they decide how soon an equilibrium is found, not which one is accepted.
MAX_UNKNOWNS = 3000
"""Largest dense problem; beyond it factorisations of the whole lattice are as cheap."""


class FactorStore:
    """Holds one factor; that of another linearisation replaces it, the analysis of the same facets is kept."""

    def __init__(self) -> None:
        self._held: Linearisation | None = None
        self._part: FacePart | None = None
        self._condenser: SymmetricCondenser | None = None
        self._stiffness: Array = np.empty((0, 0))
        self.factorisations = 0
        """How many there were so far."""

    def part(self, problem: Problem, facets: Index) -> FacePart | None:
        """Some facets with the analysis of what is condensed onto them; None where there are none, or too many."""
        if self._part is not None and np.array_equal(self._part.facets, facets):
            return self._part
        part = FacePart.of(problem.face, facets)
        if len(facets) == 0 or len(part.unknowns) > MAX_UNKNOWNS:
            return None
        pattern = problem.body_pattern
        self._held = self._part = None
        self._condenser = symmetric_condenser(
            pattern.indptr, pattern.indices, part.unknowns, is_single=problem.is_well_conditioned
        )
        self._part = part
        return part

    def factor(
        self, problem: Problem, linearisation: Linearisation
    ) -> tuple[FacePart, SymmetricCondenser, Array] | None:
        """Part of the face, factor and Schur complement of a linearisation; None where its interior is not definite."""
        part = self.part(problem, linearisation.facets)
        if part is None or self._condenser is None:
            return None
        if linearisation is not self._held:
            values = linearisation.elasticity.hessian(
                linearisation.positions, linearisation.pressure, linearisation.volume_gradient, problem.body_pattern,
                shift=linearisation.shift,
            )  # fmt: skip
            problem.body_pattern.hold(values)
            self._held = None  # until the new factor is whole, whatever interrupts it
            stiffness = self._condenser.factorise(values)
            self.factorisations += 1
            if stiffness is None:
                return None
            self._stiffness = stiffness
            self._held = linearisation
        return part, self._condenser, self._stiffness


MOST_SECANTS = 24
"""Steps that are learned from between two factorisations."""
LEAST_COSINE = 1e-8
"""Between a step and its correction, below which nothing is learned from it."""
MOST_SOFTER = 0.75
"""Part of the stiffness along a correction that it may take away."""
LEAST_PIVOT = 1e-10
"""Smallest over largest eigenvalue of M^-1 below which the last correction is forgotten."""


class _Step(NamedTuple):
    """A step that the model proposed, from the state that it was asked for last."""

    contact: Array
    """Forces on the kept unknowns that it is meant to balance, shape (kept,) [N]."""
    held: Callable[[], Array]
    """Gives the stiffness of what holds the kept unknowns, shape (kept, kept) [N/mm]."""
    start: Array
    """Positions of the nodes where it begins, shape (nodes, 3) [mm]."""


class Body:
    """The condensed model within one load step; it learns while the step is iterated."""

    def __init__(
        self, problem: Problem, condenser: SymmetricCondenser, stiffness: Array, *, shift: float = 0.0
    ) -> None:
        """Takes a factor, the Schur complement that came with it [N/mm], and the shift of the Laplacian in it."""
        self.shift = shift
        self._problem, self._condenser, self._first_stiffness = problem, condenser, stiffness
        self._columns: list[Array] = []
        """Reduced corrections, each of unit norm."""
        self._curvatures: list[float] = []
        """e^T s over |e|^2 of each [mm/N]."""
        self._inner = np.empty((0, 0))
        """E^T A^-1 E of the eliminated parts of the columns E [mm/N]."""
        self._step: _Step | None = None
        """The last step, and where it led."""
        self._end: Iterate | None = None
        self._load = self._reduced = self._beside = np.empty(0)
        """Forces without contact at the state asked for last, shape (unknowns,) [N], and reduced forms of them."""
        self._set(np.empty((0, 0)))

    @property
    def is_plain(self) -> bool:
        """Whether nothing was learned since the factorisation."""
        return not self._columns

    def at(self, iterate: Iterate) -> tuple[Array, Array]:
        """Condensed stiffness, shape (kept, kept) [N/mm], and load without contact, shape (kept,) [N], at a state."""
        load = self._problem.free_forces(-iterate.elastic.gradient).ravel()
        reduced = self._condenser.reduce(load)
        if self._step is not None and self._end is not None and self._end.positions is iterate.positions:
            self._learn(self._step, self._end, load, reduced)
            self._step = None
        self._load, self._reduced = load, reduced
        self._beside = self._condenser.inner(self._matrix, reduced)
        return self._stiffness, self._condensed_load()

    def step(self, iterate: Iterate, motion: Array, held: Callable[[], Array]) -> Array:
        """Motion of all unknowns that belongs to that of the kept ones, from the state that `at` was asked for [mm].

        `held` gives the stiffness of what holds the kept ones there, shape (kept, kept) [N/mm]; it is seldom asked.
        """
        contact = self._stiffness @ motion - self._condensed_load()
        self._step = _Step(contact, held, iterate.positions)
        amounts = self._inverse @ (self._matrix[self._condenser.kept].T @ motion + self._beside)
        return self._condenser.expand(self._reduced - self._matrix @ amounts, motion)

    def took(self, end: Iterate) -> None:
        """Notes where the step led."""
        self._end = end

    def _condensed_load(self) -> Array:
        kept = self._condenser.kept
        return np.asarray(self._reduced[kept] - self._matrix[kept] @ (self._inverse @ self._beside))

    def _learn(self, step: _Step, end: Iterate, load: Array, reduced: Array) -> None:
        """Corrects the model by what a step left."""
        if len(self._columns) >= MOST_SECANTS:
            return
        # after a share of the step the model leaves as much of the load less, and of the contact's forces more
        share, kept = end.taken, self._condenser.kept
        error = (1 - share) * self._load - load
        error[kept] -= share * step.contact
        motion = (end.positions - step.start).ravel()[: len(load)]
        size, curvature = float(np.linalg.norm(error)), float(error @ motion)
        if not abs(curvature) > LEAST_COSINE * size * float(np.linalg.norm(motion)):
            return
        column = ((1 - share) * self._reduced - reduced - share * self._condenser.lifted(step.contact)) / size
        curvature /= size**2
        if curvature < 0 and not 0 < self._compliance(column, step.held()) < -MOST_SOFTER * curvature:
            return
        count = len(self._columns)
        inner = np.empty((count + 1, count + 1))
        inner[:count, :count] = self._inner
        inner[count, :count] = inner[:count, count] = self._condenser.inner(self._matrix, column)
        inner[count, count] = self._condenser.inner(column, column)
        curvatures = np.array([*self._curvatures, curvature])
        # the inner parts may not change how many corrections soften: the model was checked for those
        spectrum = np.linalg.eigvalsh(np.diag(curvatures) + inner)
        is_regular = np.abs(spectrum).min() > LEAST_PIVOT * np.abs(spectrum).max()
        if not is_regular or (spectrum < 0).sum() != (curvatures < 0).sum():
            return
        self._columns.append(column)
        self._curvatures.append(curvature)
        self._inner = inner
        self._set(np.asarray(np.linalg.inv(np.diag(curvatures) + inner), np.float64))

    def _compliance(self, column: Array, held: Array) -> float:
        """e^T K^-1 e of the held body for reduced forces [mm/N]."""
        kept = self._condenser.kept
        beside = self._condenser.inner(self._matrix, column)
        condensed = column[kept] - self._matrix[kept] @ (self._inverse @ beside)
        inner = float(self._condenser.inner(column, column)) - float(beside @ self._inverse @ beside)
        return inner + float(condensed @ np.linalg.solve(self._stiffness + held, condensed))

    def _set(self, inverse: Array) -> None:
        self._inverse = inverse
        reduced_size = len(self._condenser.lifted(np.zeros(len(self._condenser.kept))))
        self._matrix = np.array(self._columns).reshape(-1, reduced_size).T
        condensed = self._matrix[self._condenser.kept]
        self._stiffness = self._first_stiffness + condensed @ inverse @ condensed.T
