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

from magicsim.deform.body import FIRST_SHIFT, Body, Carried, Linearisation
from magicsim.deform.contact import Surface, evaluate_contact
from magicsim.deform.face import ContactFace
from magicsim.deform.face_problem import FaceProblem, held_stiffness, solve_face
from magicsim.deform.friction import ContactMemory
from magicsim.deform.iterate import Iterate
from magicsim.deform.ladder import Rung
from magicsim.deform.linear import PardisoCondenser, has_pardiso
from magicsim.deform.problem import Problem
from magicsim.deform.search import Direction, search

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
NEEDED_MM, NEAR_MM = 0.05, 0.8
"""Facets with a point nearer to the object than the first may come into contact in this step, and nearer than the
second before long [mm]."""
MOST_REMAINING = 15.0
"""Iterations that remain at the present rate above which a new factor is made: it costs as much as some of them."""
SHORTER, LONGER = 1.0, 1.3
"""Factors of the way after which a factor is expected to serve no longer: of the way on which one has failed, and each
time that one is made for that reason, so that it is tried again now and then."""
LONGEST_MM = 1e3
"""A longer motion of the face is none."""
FAR = 0.3
"""So does a residual above this after the first step with the factor of an earlier load step."""
MAX_UNKNOWNS = 1500
"""Largest dense problem; beyond it factorisations of the whole lattice are as cheap."""
GIVEN_UP_SHARE = 1 / 3
"""A load step is given up after this part of `NewtonOptions.max_iterations`: condensed ones need few."""
ON_ITS_WAY = 1e-3
"""Residual below which it is not: where the body is close to folding, the last digits come slowly."""


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
        solver = PardisoCondenser(
            problem.pattern.indptr, problem.pattern.indices, kept, is_single=problem.is_well_conditioned
        )
        return cls(facets=facets, points=points, nodes=nodes, face=part, solver=solver)


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstStep:
    """What helps the first step of a load step."""

    predictor: Surface
    """A surface that the face follows roughly before the object's own decides."""
    pressed: Index
    """Points of the face that were pressed at the end of the last load step; they may still be in a retreat."""


class Condenser:
    """Holds the body's model: that of the last state of a path, or one made anew where it has become a poor one.

    What comes out depends on the path alone: a model is a function of its `Linearisation`, which a path's states carry.
    """

    def __init__(self) -> None:
        """Starts without one."""
        self._part: Condensation | None = None
        self._known: Linearisation | None = None
        self._schur: Array = np.empty(0)
        self._body: Body | None = None
        self._wanted: Linearisation | None = None
        self._residual = np.inf
        self.factorisations = 0

    def begin(self, carried: Carried | None, way_mm: float) -> None:
        """Begins a load step.

        Args:
            carried: By the state that it starts from; None where there is nothing.
            way_mm: How far the object moves [mm].
        """
        linearisation = carried.linearisation if carried is not None else None
        if linearisation is not self._wanted or linearisation is not self._known:
            self._body = None
        if self._body is not None:
            self._body.forget()
        self._wanted, self._residual, self._is_old = linearisation, np.inf, True
        self._facets = np.empty(0, np.int64) if linearisation is None else linearisation.facets
        self._serves_mm, self._moved_mm = (np.inf, 0.0) if carried is None else (carried.serves_mm, carried.moved_mm)
        self._moved_mm += way_mm
        if self._moved_mm > self._serves_mm:
            self._wanted, self._moved_mm, self._serves_mm = None, 0.0, LONGER * self._serves_mm

    @property
    def carried(self) -> Carried | None:
        """For the next load step."""
        if self._wanted is None:
            return None
        return Carried(linearisation=self._wanted, moved_mm=self._moved_mm, serves_mm=self._serves_mm)

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
        facets = near_facets(problem.face, iterate, NEEDED_MM)
        if first is not None:
            facets = np.union1d(facets, problem.face.facet[first.pressed])
        is_slow = iterate.shortened or remaining_steps(problem, self._residual, iterate.residual) > MOST_REMAINING
        is_far = self._is_old and iterate.residual > FAR
        if first is None and (is_slow or is_far or not problem.options.keeps_factors):
            self._drop()
        while True:
            body = self._model(problem, iterate, facets)
            if body is None or self._part is None:
                return None
            if iterate.iteration >= GIVEN_UP_SHARE * problem.options.max_iterations and iterate.residual > ON_ITS_WAY:
                return replace(iterate, stuck=True)
            found = _step(problem, self._part, body, surface, iterate, first.predictor if first else None)
            if found is None:
                if self._is_fresh(body, iterate):
                    return None
                self._drop()
                continue
            reached = np.unique(problem.face.facet[found.contact.acting])
            missing = np.setdiff1d(reached, self._part.facets)
            is_poor = found.stuck or found.shortened or (first is None and found.residual > iterate.residual)
            if is_poor and not self._is_fresh(body, iterate):
                self._drop()
                continue
            if len(missing) == 0 or found.shortened:
                body.took(iterate, found)
                self._residual = np.inf if first is not None else iterate.residual
                shift = self._wanted.shift if self._wanted is not None else 0.0
                found = replace(found, shift=shift)
                return found.on(Rung.SHIFTED) if shift > 0 else found
            facets = np.union1d(np.union1d(facets, self._facets), near_facets(problem.face, found, NEAR_MM))

    def _drop(self) -> None:
        """Gives the model up; where it came from an earlier load step that was too far away."""
        if self._is_old and self._wanted is not None and self._moved_mm > 0:
            self._serves_mm = SHORTER * self._moved_mm
        self._wanted, self._moved_mm = None, 0.0

    def _is_fresh(self, body: Body, iterate: Iterate) -> bool:
        wanted = self._wanted
        return wanted is not None and wanted.positions is iterate.positions and body.is_plain

    def _model(self, problem: Problem, iterate: Iterate, facets: Index) -> Body | None:
        """The model to step with; one made at this state where there is none, or none that holds these facets."""
        wanted = self._wanted
        holds = wanted is not None and len(np.setdiff1d(facets, wanted.facets)) == 0
        if wanted is not None and holds:
            if self._body is None:
                self._hold(problem, wanted)
                if self._part is None:
                    return None
                self._body = Body(problem, self._part.solver, self._schur)
            return self._body
        if len(np.setdiff1d(facets, self._facets)) == 0:
            facets = self._facets
        else:
            facets = np.union1d(facets, near_facets(problem.face, iterate, NEAR_MM))
        shift = iterate.shift / 4 if iterate.shift > FIRST_SHIFT else 0.0
        self._body = None
        while shift < problem.options.last_shift:
            wanted = Linearisation(
                elasticity=problem.elasticity, positions=iterate.positions, pressure=iterate.pressure, shift=shift,
                facets=facets,
            )
            if self._hold(problem, wanted, iterate.elastic.volume_gradient):
                break
            if self._part is None:
                return None
            shift = max(FIRST_SHIFT, 4 * shift)
        else:
            return None
        self._wanted, self._facets, self._is_old = wanted, facets, False
        if self._part is None:
            return None
        self._body = Body(problem, self._part.solver, self._schur)
        return self._body

    def _hold(self, problem: Problem, wanted: Linearisation, volume_gradient: Array | None = None) -> bool:
        """Makes the factor of a linearisation the one that is held."""
        if wanted is self._known:
            return True
        if self._part is None or not np.array_equal(self._part.facets, wanted.facets):
            self._part = Condensation.of(problem, wanted.facets)
        if self._part is None:
            return False
        if volume_gradient is None:
            volume_gradient = wanted.elasticity.evaluate(wanted.positions).volume_gradient
        values = wanted.elasticity.hessian(
            wanted.positions, wanted.pressure, volume_gradient, problem.pattern, shift=wanted.shift
        )
        problem.pattern.hold(values)
        schur = self._part.solver.factorise(values)
        self.factorisations += 1
        self._known = None if schur is None else wanted
        self._schur = self._schur if schur is None else schur
        return schur is not None


def remaining_steps(problem: Problem, before: float, residual: float) -> float:
    """How many iterations convergence will take if they go on as the last one did; infinite where they do not.

    Args:
        problem: With the residual that is asked for.
        before: Residual before the last step, infinite where there was none.
        residual: After it.
    """
    if residual >= before:
        return np.inf
    return max(0.0, float(np.log(residual / problem.options.residual) / np.log(before / residual)))


def near_facets(face: ContactFace, iterate: Iterate, near_mm: float) -> Index:
    """Facets with a point in contact, held by friction or near the object, ascending."""
    is_near = iterate.contact.gap_mm < near_mm
    is_near[iterate.contact.acting] = True
    return np.unique(face.facet[is_near])


def _step(
    problem: Problem, part: Condensation, body: Body, surface: Surface, iterate: Iterate, predictor: Surface | None
) -> Iterate | None:
    stiffness, load = body.at(iterate)
    face_problem = FaceProblem(
        face=part.face,
        positions=iterate.positions[part.nodes],
        stiffness=stiffness,
        load=load,
        held=problem.pattern.held[part.solver.kept],
        surface=surface,
        law=problem.law,
        options=problem.options,
        cautious=problem.stiffness / 4,
        least_force_n=problem.least_force_n,
    )
    solved = solve_face(
        face_problem, _part_of(iterate.memory, part.points), accuracy=iterate.residual, predictor=predictor
    )
    if solved is None or np.abs(solved[0]).max() > LONGEST_MM:
        return None
    motion, memory = solved
    nodes = np.zeros_like(iterate.positions)
    nodes[: problem.pattern.size // 3] = body.expand(motion, held_stiffness(face_problem, motion, memory)).reshape(-1, 3)
    memory = _whole(memory, iterate.memory, part.points)
    contact = evaluate_contact(problem.face, iterate.positions, surface, memory, problem.law)
    start = replace(iterate, memory=memory, contact=contact)
    shift = iterate.shift
    found = search(problem, surface, start, Direction(nodes=nodes, shift=shift, is_stiffened=shift > 0))
    return replace(found, iteration=iterate.iteration + 1)


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
