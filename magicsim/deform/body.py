"""The body as the face feels it: its stiffness at one state, condensed, and what later states taught about it.

Factorising is most of what an equilibrium costs, and the stiffness of the body changes little from one state of a path
to the next. So it is factorised where it was last worth it (a `Linearisation`), and what has changed since is learned
from the steps themselves. A step s from the model K is meant to leave the forces K s behind; what the gradient of the
energy leaves instead, e = dg - K s, corrects the model,

    K <- K + e e^T / (e^T s),

the symmetric rank-one formula (Nocedal and Wright 2006, 6.2), which needs no definite matrix. On a quadratic energy all
earlier steps stay exact, so iterations converge like a Krylov method with the old factor as its preconditioner. Contact
has no part in it: it is solved in full on the model, and e is smooth in the state.

With interior unknowns i eliminated and E the columns e, D^-1 = diag(e^T s), the condensed model is

    S = S_0 + R M R^T,   y = y_0 - R M h,   M = (D^-1 + E_i^T K_ii^-1 E_i)^-1,

R being the condensed E and h = E_i^T K_ii^-1 r_i: products of halves of solutions that every step computes anyway.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.deform.energy import Elasticity
from magicsim.deform.iterate import Iterate
from magicsim.deform.linear import PardisoCondenser
from magicsim.deform.problem import Problem

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
FIRST_SHIFT = 1 / 64
"""Least multiple of the spring Laplacian added where the interior is not positive definite: as little as will do, since
convergence is linear with it."""
MOST_SECANTS = 24
"""Steps that are learned from between two factorisations."""
LEAST_SECANT = 1e-8
"""Cosine between a step and its correction below which nothing is learned from it."""
MOST_SOFTER = 0.75
"""Part of the stiffness along a correction that it may take away."""
LEAST_PIVOT = 1e-10
"""Smallest over largest eigenvalue of M^-1 from which on the last correction is forgotten."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Linearisation:
    """Where a body's stiffness was taken, and the part of the face that it was condensed onto."""

    elasticity: Elasticity
    """Energy of the body; it changes with every step of a path that takes time."""
    positions: Array
    """Of the nodes, shape (nodes, 3) [mm]."""
    pressure: Array
    """Volumetric stress of each cell, shape (cells,) [MPa]."""
    shift: float
    """Multiple of the spring Laplacian that was added."""
    facets: Index
    """Of the face, ascending."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Carried:
    """What a path hands from state to state to save factorisations."""

    linearisation: Linearisation
    moved_mm: float
    """Way of the object since then [mm]."""
    serves_mm: float
    """Way after which it is expected to serve no longer [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Secant:
    """One correction, of unit norm."""

    reduced: Array
    """Condensed at the kept unknowns, half a solution at the others, shape (unknowns,)."""
    curvature: float
    """e^T s over |e|^2 [mm/N]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Proposal:
    """A step that was proposed from a state, as far as the correction at the next state needs it."""

    load: Array
    """Forces without contact before it, shape (unknowns,) [N]."""
    reduced: Array
    """Their forward half."""
    contact: Array
    """Forces on the kept unknowns that the step is meant to balance, shape (kept,) [N]."""


class Body:
    """The condensed model within one load step; it learns while the step is iterated."""

    def __init__(self, problem: Problem, solver: PardisoCondenser, stiffness: Array) -> None:
        """Takes a factor and the Schur complement that came with it, shape (kept, kept) [N/mm]."""
        self._problem, self._solver, self._own = problem, solver, stiffness
        self._secants: list[_Secant] = []
        self._interior = np.setdiff1d(np.arange(problem.pattern.size), solver.kept)
        self._proposal: _Proposal | None = None
        self._taken: tuple[Iterate, Iterate, float] | None = None
        self._set(np.empty((0, 0)))

    @property
    def is_full(self) -> bool:
        """Whether as many steps were learned from as are kept."""
        return len(self._secants) >= MOST_SECANTS

    @property
    def is_plain(self) -> bool:
        """Whether nothing was learned since the factorisation."""
        return not self._secants

    def at(self, iterate: Iterate) -> tuple[Array, Array]:
        """Condensed stiffness, shape (kept, kept) [N/mm], and load without contact, shape (kept,) [N], at a state.

        Args:
            iterate: Where the last step led, or where the first one begins.
        """
        load = self._problem.free_forces(-iterate.elastic.gradient).ravel()
        reduced = self._solver.reduce(load)
        if self._taken is not None and self._taken[1].positions is iterate.positions:
            self._learn(load, reduced)
        self._load, self._reduced = load, reduced
        self._half_load = self._halves.T @ reduced[self._interior]
        kept = reduced[self._solver.kept]
        return self._stiffness, kept - self._condensed @ (self._inverse @ self._half_load)

    def expand(self, motion: Array, held: Array) -> Array:
        """Motion of all unknowns that belongs to that of the kept ones, shape (unknowns,) [mm].

        Args:
            motion: Of the kept unknowns, shape (kept,) [mm].
            held: Stiffness of what holds them there, shape (kept, kept) [N/mm].
        """
        self._held = held
        amounts = self._inverse @ (self._condensed.T @ motion + self._half_load)
        contact = self._stiffness @ motion - self._reduced[self._solver.kept] + self._condensed @ (
            self._inverse @ self._half_load)
        self._proposal = _Proposal(load=self._load, reduced=self._reduced, contact=contact)
        right = self._reduced.copy()
        right[self._interior] -= self._halves @ amounts
        right[self._solver.kept] = motion
        return self._solver.expand(right)

    def forget(self):
        self._taken=self._proposal=None

    def took(self, before: Iterate, after: Iterate) -> None:
        """Notes where the proposed step led."""
        self._taken = before, after, after.taken

    def _learn(self, load: Array, reduced: Array) -> None:
        if self._taken is None or self._proposal is None or self.is_full:
            return
        before, after, share = self._taken
        proposal, kept = self._proposal, self._solver.kept
        error = (1 - share) * proposal.load - load
        error[kept] -= share * proposal.contact
        size = float(np.linalg.norm(error))
        step = (after.positions - before.positions).ravel()[: len(load)]
        curvature = float(error @ step)
        if not abs(curvature) > LEAST_SECANT * size * float(np.linalg.norm(step)):
            return
        half = (1 - share) * proposal.reduced - reduced
        half[kept] -= share * proposal.contact
        if curvature < 0 and not 0 < self._compliance(half) < MOST_SOFTER * -curvature:
            return
        self._secants.append(_Secant(reduced=half / size, curvature=curvature / size**2))
        halves = np.stack([secant.reduced[self._interior] for secant in self._secants], axis=1)
        matrix = np.diag([secant.curvature for secant in self._secants]) + halves.T @ halves
        spectrum = np.linalg.eigvalsh(matrix)
        softer = sum(secant.curvature < 0 for secant in self._secants)
        if (spectrum < 0).sum() != softer or np.abs(spectrum).min() < LEAST_PIVOT * np.abs(spectrum).max():
            self._secants.pop()
            return
        self._set(np.linalg.inv(matrix))

    def _compliance(self, half: Array) -> float:
        """e^T K^-1 e of forces whose forward half is given [N mm]."""
        own = half[self._interior]
        beside = self._halves.T @ own
        condensed = half[self._solver.kept] - self._condensed @ (self._inverse @ beside)
        inner = float(own @ own - beside @ self._inverse @ beside)
        return inner + float(condensed @ np.linalg.solve(self._stiffness + self._held, condensed))

    def _set(self, inverse: Array) -> None:
        kept, count = self._solver.kept, len(self._secants)
        columns = np.array([secant.reduced for secant in self._secants]).reshape(count, self._problem.pattern.size)
        self._inverse = inverse
        self._halves, self._condensed = columns[:, self._interior].T, columns[:, kept].T
        self._stiffness = self._own + self._condensed @ inverse @ self._condensed.T
