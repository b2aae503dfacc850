"""Newton iterations on the body with the contact solved in full for each of them.

Almost all of what happens between an object and the face happens on the face: points touch or leave, stick or slip,
multipliers and friction limits follow the pressures. The body only has to say how stiff the face is. So the Hessian of
the energy alone is condensed onto the nodes near the object (a Schur complement S, dense, made by the factorisation),
the contact problem of that linearised body

    S u = y + f(u)

is solved with small dense matrices (`face_problem`), and the body then takes the whole step. A step costs one
factorisation, as a plain Newton step does, but a load step needs one for each iteration of the body's own nonlinearity
and not one for each change of the contact.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from magicsim.deform.contact import Surface, evaluate_contact
from magicsim.deform.face import ContactFace
from magicsim.deform.face_problem import FaceProblem, solve_face
from magicsim.deform.friction import ContactMemory
from magicsim.deform.iterate import Iterate
from magicsim.deform.linear import PardisoCondenser, has_pardiso
from magicsim.deform.problem import Problem
from magicsim.deform.search import Direction, search

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
NEAR_MM = 0.15
"""Facets with a point nearer to the object than this may come into contact [mm]."""
MAX_UNKNOWNS = 1500
"""Largest dense problem; beyond it factorisations of the whole lattice are as cheap."""
GIVEN_UP_SHARE = 1 / 3
"""A load step is given up after this part of `NewtonOptions.max_iterations`: condensed ones need few."""
ON_ITS_WAY = 1e-3
"""Residual below which it is not: where the body is close to folding, the last digits come slowly."""
FIRST_SHIFT = 1 / 64
"""Least multiple of the spring Laplacian added where the condensed part is not positive definite: as little as will do,
since convergence is linear with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Condensation:
    """The part of the face that may touch, and the solver that condenses the body onto it."""

    facets: Index
    """Of the whole face, ascending."""
    points: Index
    """Contact points on them, ascending."""
    nodes: Index
    """That move those points, ascending, shape (nodes,)."""
    face: ContactFace
    """Those facets alone, patches in terms of `nodes`."""
    solver: PardisoCondenser

    @classmethod
    def of(cls, problem: Problem, facets: Index) -> Self | None:
        """Prepares some facets; None where there are none, or too many to gain anything.

        Args:
            problem: The lattice.
            facets: Ascending.
        """
        face = problem.face
        nodes = np.unique(face.patches[facets])
        if len(facets) == 0 or 3 * len(nodes) > MAX_UNKNOWNS:
            return None
        points = np.flatnonzero(np.isin(face.facet, facets))
        part = ContactFace(
            patches=np.searchsorted(nodes, face.patches[facets]),
            facet=np.searchsorted(facets, face.facet[points]),
            shape=face.shape[points],
            slopes=face.slopes[points],
            area_mm2=face.area_mm2[points],
        )
        kept = (3 * nodes[:, None] + np.arange(3)).ravel()
        solver = PardisoCondenser(problem.pattern.indptr, problem.pattern.indices, kept)
        return cls(facets=facets, points=points, nodes=nodes, face=part, solver=solver)


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstStep:
    """What helps the first step of a load step."""

    predictor: Surface
    """A surface that the face follows roughly before the object's own decides."""
    pressed: Index
    """Points of the face that were pressed at the end of the last load step; they may still be in a retreat."""


class Condenser:
    """Keeps the condensation of the last step: within a load step the facets that may touch only grow.

    Each load step begins with its own, so that it does not matter in the last bits what was solved before.
    """

    def __init__(self) -> None:
        """Starts without one."""
        self._last: Condensation | None = None

    def step(
        self, problem: Problem, surface: Surface, iterate: Iterate, *, first: FirstStep | None = None
    ) -> Iterate | None:
        """One step of the body with the contact that belongs to it; None where this way does not lead on.

        Args:
            problem: The lattice and its tolerances.
            surface: The object in the pose of this load step.
            iterate: Where the step begins.
            first: What helps the first step of a load step.
        """
        if not (problem.options.is_condensed and has_pardiso()):
            return None
        facets = near_facets(problem.face, iterate)
        if first is not None:
            facets = np.union1d(facets, problem.face.facet[first.pressed])
        elif self._last is not None:
            facets = np.union1d(facets, self._last.facets)
        while True:
            condensation = self._condensation(problem, facets)
            if condensation is None:
                return None
            if iterate.iteration >= GIVEN_UP_SHARE * problem.options.max_iterations and iterate.residual > ON_ITS_WAY:
                return replace(iterate, stuck=True)
            found = _step(problem, condensation, surface, iterate, first.predictor if first else None)
            if found is None:
                return None
            reached = np.unique(problem.face.facet[found.contact.acting])
            missing = np.setdiff1d(reached, condensation.facets)
            if len(missing) == 0 or found.shortened:
                return found
            facets = np.union1d(facets, near_facets(problem.face, found))

    def _condensation(self, problem: Problem, facets: Index) -> Condensation | None:
        if self._last is None or not np.array_equal(self._last.facets, facets):
            self._last = Condensation.of(problem, facets)
        return self._last


def near_facets(face: ContactFace, iterate: Iterate) -> Index:
    """Facets with a point in contact, held by friction or near the object, ascending."""
    is_near = iterate.contact.gap_mm < NEAR_MM
    is_near[iterate.contact.acting] = True
    return np.unique(face.facet[is_near])


def _step(
    problem: Problem, part: Condensation, surface: Surface, iterate: Iterate, predictor: Surface | None
) -> Iterate | None:
    options, pattern = problem.options, problem.pattern
    shift = iterate.shift / 4 if iterate.shift > FIRST_SHIFT else 0.0
    schur: Array | None = None
    while schur is None:
        if shift >= options.last_shift:
            return None
        values = problem.elasticity.hessian(
            iterate.positions, iterate.pressure, iterate.elastic.volume_gradient, pattern, shift=shift
        )
        pattern.hold(values)
        schur = part.solver.factorise(values)
        if schur is None:
            shift = max(FIRST_SHIFT, 4 * shift)
    right = part.solver.reduce(problem.free_forces(-iterate.elastic.gradient).ravel())
    held = pattern.held[part.solver.kept]
    face_problem = FaceProblem(
        face=part.face,
        positions=iterate.positions[part.nodes],
        stiffness=schur,
        load=right[part.solver.kept],
        held=held,
        surface=surface,
        law=problem.law,
        options=options,
        cautious=problem.stiffness / 4,
        least_force_n=problem.least_force_n,
    )
    solved = solve_face(
        face_problem, _part_of(iterate.memory, part.points), accuracy=iterate.residual, predictor=predictor
    )
    if solved is None:
        return None
    motion, memory = solved
    right[part.solver.kept] = motion
    nodes = np.zeros_like(iterate.positions)
    nodes[: pattern.size // 3] = part.solver.expand(right).reshape(-1, 3)
    memory = _whole(memory, iterate.memory, part.points)
    contact = evaluate_contact(problem.face, iterate.positions, surface, memory, problem.law)
    start = replace(iterate, memory=memory, contact=contact)
    found = search(problem, surface, start, Direction(nodes=nodes, shift=shift, is_stiffened=shift > 0))
    return replace(found, iteration=iterate.iteration + 1, shift=shift)


def _part_of(memory: ContactMemory, points: Index) -> ContactMemory:
    excess = memory.limit_excess_mpa
    return replace(
        memory,
        multipliers_mpa=memory.multipliers_mpa[points],
        anchors_mm=memory.anchors_mm[points],
        limit_mpa=memory.limit_mpa[points],
        normal=memory.normal[points],
        limit_excess_mpa=None if excess is None else excess[points],
    )


def _whole(part: ContactMemory, whole: ContactMemory, points: Index) -> ContactMemory:
    """The memory of the whole face with that of some points put in."""

    def put(values: Array, own: Array) -> Array:
        result = values.copy()
        result[points] = own
        return result

    excess = part.limit_excess_mpa
    return replace(
        part,
        multipliers_mpa=put(whole.multipliers_mpa, part.multipliers_mpa),
        anchors_mm=whole.anchors_mm,
        limit_mpa=put(whole.limit_mpa, part.limit_mpa),
        normal=put(whole.normal, part.normal),
        limit_excess_mpa=None if excess is None else put(np.zeros_like(whole.limit_mpa), excess),
    )
