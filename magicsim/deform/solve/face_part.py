"""The part of the contact face that may come into contact: what contact remembers there, and its matrix.

The contact problem of a linearised body has the matrix S + B. S stays while the contact settles; B, the contact's own
stiffness, changes with every step and is zero but at the nodes a that move a point in contact. With the others i

    (S_aa - C^T C + B_aa) u_a = r_a - C^T h,   L^T u_i = h - C u_a,   S_ii = L L^T,   C = L^-1 S_ia,   h = L^-1 r_i,

so a step factorises a matrix of the touched nodes alone: where a cylinder lies on the face these are half of those that
may come into contact, and their factor costs an eighth. The solution is that of S + B but for rounding.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, cholesky, solve_triangular

from magicsim.arrays import Array, Index, Mask
from magicsim.deform.contact.augmented import add_dense_stiffness
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.solve.iterate import Iterate

LARGE = 900
"""Unknowns from which the contact of a linearised body costs as much as the body's own factor: below, its matrix is
small change."""

FEW = 2
"""Solutions for which nothing is eliminated where the face is not large: most contacts settle in as few."""
SETTLED = ("multipliers_mpa", "limit_mpa", "normal")
"""Fields of the memory of each point that change while contact settles."""
WORTH = 0.8
"""Touched nodes, in units of those that are left, below which the others are eliminated anew."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FacePart:
    """Some facets of a face."""

    facets: Index
    """Facets of the whole face, ascending."""
    points: Index
    """Contact points on them, ascending."""
    nodes: Index
    """That move those points, ascending, shape (nodes,)."""
    face: ContactFace
    """Those facets alone, patches in terms of `nodes`."""

    @classmethod
    def of(cls, face: ContactFace, facets: Index) -> Self:
        """Some facets of a face, ascending."""
        nodes = np.unique(face.patches[facets])
        points = np.flatnonzero(np.isin(face.facet, facets))
        part = ContactFace(
            patches=np.searchsorted(nodes, face.patches[facets]),
            facet=np.searchsorted(facets, face.facet[points]),
            shape=face.shape[points],
            slopes=face.slopes[points],
            area_mm2=face.area_mm2[points],
        )
        return cls(facets=facets, points=points, nodes=nodes, face=part)

    @property
    def unknowns(self) -> Index:
        """Numbers of the nodes' unknowns, ascending, shape (3 nodes,)."""
        return np.asarray((3 * self.nodes[:, None] + np.arange(3)).ravel())

    def memory(self, whole: ContactMemory) -> ContactMemory:
        """Memory of contact at these points."""
        excess = whole.limit_excess_mpa
        own = {name: getattr(whole, name)[self.points] for name in (*SETTLED, "anchors_mm")}
        return replace(whole, **own, limit_excess_mpa=None if excess is None else excess[self.points])

    def put_back(self, own: ContactMemory, whole: ContactMemory) -> ContactMemory:
        """The memory of the whole face with that of these points put in; anchors stay until a load step ends."""
        excess = None if own.limit_excess_mpa is None else np.zeros_like(whole.limit_mpa)
        if excess is not None:
            excess[self.points] = own.limit_excess_mpa
        settled = {name: getattr(whole, name).copy() for name in SETTLED}
        for name, values in settled.items():
            values[self.points] = getattr(own, name)
        return replace(own, **settled, anchors_mm=whole.anchors_mm, limit_excess_mpa=excess)


def near_facets(face: ContactFace, iterate: Iterate, near_mm: float) -> Index:
    """Facets with a point in contact, held by friction or nearer to the object than `near_mm`, ascending."""
    is_near = iterate.contact.gap_mm < near_mm
    is_near[iterate.contact.acting] = True
    return np.unique(face.facet[is_near])


def is_large(face: ContactFace, facets: Index) -> bool:
    """Whether the contact on some facets costs as much as a factor of the body."""
    return 3 * len(np.unique(face.patches[facets])) > LARGE


class TouchedMatrix:
    """Solves with S + B; it remembers which nodes it has eliminated last."""

    def __init__(self, stiffness: Array, held: Mask) -> None:
        """Takes S, three unknowns a node [N/mm], and which of them stay zero: there S is a unit matrix."""
        self._stiffness, self._held = stiffness, held
        self._is_left: Mask = np.zeros(len(stiffness) // 3, bool)
        """Which nodes are not eliminated."""
        self._left: Index = np.empty(0, np.int64)
        self._others: Index = np.empty(0, np.int64)
        """Unknowns that are left, and that are eliminated."""
        self._factor: Array = np.empty((0, 0))
        self._coupling: Array = np.empty((0, 0))
        self._reduced: Array = np.empty((0, 0))
        """L, C and S_aa - C^T C."""
        self._is_definite = False
        self._solved = 0
        """How often it has solved."""

    def solve(self, face: ContactFace, acting: Index, local: Array, right: Array) -> Array | None:
        """Solution u of (S + B) u = r, shape (unknowns,) [mm]; None where the matrix is not positive definite.

        B belongs to the points that act, with their own stiffness, shape (acting, 3, 3) [N/mm].
        """
        self._solved += 1
        if self._solved <= FEW and len(self._stiffness) <= LARGE:
            factor = _held_factor(self._stiffness, self._held, face, acting, local)
            return None if factor is None else np.asarray(cho_solve(factor, right, check_finite=False))
        touched = np.zeros_like(self._is_left)
        touched[face.patches[np.unique(face.facet[acting])]] = True
        if (touched & ~self._is_left).any() or touched.sum() < WORTH * self._is_left.sum():
            self._eliminate(touched)
        if not self._is_definite:
            return None
        place = np.cumsum(self._is_left) - 1
        own = replace(face, patches=place[face.patches])
        factor = _held_factor(self._reduced, self._held[self._left], own, acting, local)
        if factor is None:
            return None
        half = self._half(right[self._others])
        moved = np.asarray(cho_solve(factor, right[self._left] - half @ self._coupling, check_finite=False))
        solution = np.zeros_like(right)
        solution[self._left] = moved
        solution[self._others] = self._half(half - self._coupling @ moved, is_back=True)
        return solution

    def _eliminate(self, touched: Mask) -> None:
        """Eliminates all nodes but some."""
        self._is_left = touched
        self._left, self._others = np.flatnonzero(np.repeat(touched, 3)), np.flatnonzero(np.repeat(~touched, 3))
        across = self._stiffness[np.ix_(self._others, self._left)]
        try:
            self._factor = cholesky(self._stiffness[np.ix_(self._others, self._others)], lower=True, check_finite=False)
        except LinAlgError:
            self._is_definite = False
            return
        self._is_definite = True
        self._coupling = self._half(across)
        self._reduced = self._stiffness[np.ix_(self._left, self._left)] - self._coupling.T @ self._coupling

    def _half(self, right: Array, *, is_back: bool = False) -> Array:
        return np.asarray(
            solve_triangular(self._factor, right, lower=True, trans="T" if is_back else "N", check_finite=False)
        )


def _held_factor(
    stiffness: Array, held: Mask, face: ContactFace, acting: Index, local: Array
) -> tuple[Array, bool] | None:
    """Factor of a stiffness with that of contact points, held unknowns apart; None where it is not definite."""
    matrix = stiffness.copy()
    add_dense_stiffness(matrix, face, acting, local)
    matrix[held], matrix[:, held] = 0.0, 0.0
    matrix[held, held] = 1.0
    try:
        factor, is_lower = cho_factor(matrix.T, lower=True, overwrite_a=True, check_finite=False)
    except LinAlgError:
        return None
    return factor, is_lower
