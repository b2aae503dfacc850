"""Newton iterations on the body with the contact solved in full for each of them.

Almost all of what happens between an object and the face happens on the face: points touch or leave, stick or slip,
multipliers and friction limits follow the pressures. The body only has to say how stiff the face is. So the Hessian of
the energy alone is condensed onto the nodes near the object (a Schur complement S, dense, made by the factorisation),
the contact problem of that linearised body

    S u = y + f(u)

is solved with small dense matrices (`face_problem`), and the body then takes the whole step. The factor is kept over
iterations and load steps as long as it does well (`factor`), with what the steps teach added to it (`body`).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from magicsim.arrays import Index
from magicsim.deform.contact.augmented import Surface, remembered
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.solve.body import Body, FactorStore
from magicsim.deform.solve.descent import search
from magicsim.deform.solve.face_part import FacePart, TouchedMatrix, is_large, near_facets
from magicsim.deform.solve.face_problem import FaceProblem, held_stiffness, solve_face
from magicsim.deform.solve.iterate import Iterate
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import Problem

# Numbers without a source are assumed: they decide how soon an equilibrium is found, not which one is accepted.
NEEDED_MM, NEAR_MM = 0.05, (0.25, 0.8)
"""Facets with a point nearer to the object than the first may come into contact in this step [mm], and nearer than two
of the smallest cell edges, between the others, before long: fine facets are many."""
NEAR_EDGES = 2.0
"""How many of these edges."""
MOST_REMAINING, FEW_UNKNOWNS = 6.0, 25_000
"""Iterations that remain at the present rate above which a new factor is made: it costs as much as some of them, and
beyond so many unknowns as more, by their power of 2/3 (nested dissection in three dimensions: George 1973): as sixteen
of 115,000, measured on lattices of one spacing."""
FAR = 0.3
"""Residual above which every step but the first has its own factor."""
GIVEN_UP_SHARE = 1 / 3
"""A load step is given up after this part of `NewtonOptions.max_iterations`: condensed ones need few."""
ON_ITS_WAY = 1e-3
"""Residual below which it is not: where the body is close to folding, the last digits come slowly."""
FIRST_SHIFT = 1 / 64
"""Least multiple of the spring Laplacian added where the interior is not definite: as little as will do, since
convergence is linear with it."""
LONGEST_MM = 1e3
"""A longer motion of the face is none."""


class Condenser:
    """Takes the steps of one load step after the other, with the body's model of the last ones while it does well."""

    def __init__(self) -> None:
        self.store = FactorStore()
        self.linearisation: Linearisation | None = None
        """Linearisation of the model that served last."""
        self._body: Body | None = None
        self._part: FacePart | None = None
        self._facets: Index = np.empty(0, np.int64)
        self._residuals: tuple[float, ...] = ()
        """Before the last steps of one problem, the latest last."""

    def begin(self, linearisation: Linearisation | None) -> None:
        """Begins a load step with the linearisation that its start carries, if any."""
        self.linearisation = linearisation
        self._facets = np.empty(0, np.int64) if linearisation is None else linearisation.facets
        self._body, self._residuals = None, ()

    def step(
        self,
        problem: Problem,
        surface: Surface,
        iterate: Iterate,
        *,
        pressed: Index | None = None,
        predictor: Surface | None = None,
    ) -> Iterate | Rung:
        """One step of the body with the contact that belongs to it; a reason (`WHY_PLAIN`) where none can be taken.

        The first step of a load step is told which points of the face were pressed at the end of the last one: they may
        still be in a retreat. Where the object has gone far, the face follows a predictor roughly before its own
        surface decides.
        """
        is_first = pressed is not None
        needed = near_facets(problem.face, iterate, NEEDED_MM)
        if pressed is not None:
            needed = np.union1d(needed, problem.face.facet[pressed])
        elif self._asks_for_factor(problem, iterate):
            self._drop()
        while True:
            body = self._model(problem, iterate, needed)
            if isinstance(body, Rung):
                return body
            assert self._part is not None  # a body is condensed onto it
            if iterate.iteration >= GIVEN_UP_SHARE * problem.options.max_iterations and iterate.residual > ON_ITS_WAY:
                return replace(iterate, stuck=True)
            end = _step(problem, self._part, body, surface, iterate, predictor)
            is_poor = end is None or end.stuck or end.shortened
            if end is not None and not is_poor and not is_first:
                is_poor = end.residual > self._expected(iterate, end)
            is_fresh = self.linearisation is not None and self.linearisation.positions is iterate.positions
            if is_poor and not (is_fresh and body.is_plain):  # a better model can be made
                self._drop()
                continue
            if end is None:
                return Rung.UNSOLVED
            missing = np.setdiff1d(problem.face.facet[end.contact.acting], self._part.facets)
            if len(missing) == 0 or end.shortened:
                break
            needed = np.union1d(np.union1d(needed, self._facets), _expected_facets(problem, end))
        body.took(end)
        is_another = is_first or end.memory.updates != iterate.memory.updates
        self._residuals = () if is_another else (*self._residuals[-1:], iterate.residual)
        return end.on(Rung.SHIFTED) if end.shift > 0 else end

    def _expected(self, iterate: Iterate, end: Iterate) -> float:
        """Residual that a step has to beat; any will do where multipliers were updated, which makes another problem.

        Steps of a model that learns do not come down one by one: near balance one has to beat the largest of the last.
        """
        if end.memory.updates != iterate.memory.updates:
            return np.inf
        return max((iterate.residual, *self._residuals)) if iterate.residual < ON_ITS_WAY else iterate.residual

    def _asks_for_factor(self, problem: Problem, iterate: Iterate) -> bool:
        """Whether a new factor is worth its cost."""
        remaining = remaining_steps(self._residuals, iterate.residual, problem.options.residual)
        affordable = MOST_REMAINING * max(1.0, problem.pattern.size / FEW_UNKNOWNS) ** (2 / 3)
        is_slow = iterate.shortened or iterate.shift > 0 or remaining > affordable or iterate.residual > FAR
        return is_slow or not problem.options.keeps_factors

    def _drop(self) -> None:
        self.linearisation, self._body = None, None

    def _model(self, problem: Problem, iterate: Iterate, needed: Index) -> Body | Rung:
        """The model to step with: a new one at this state where there is none, or none that has all facets needed.

        Where none can be made, why.
        """
        last = self.linearisation
        if last is not None and len(np.setdiff1d(needed, last.facets)) == 0:
            if self._body is None:
                self._body = self._body_of(problem, last)
            return self._body or Rung.INDEFINITE
        if len(np.setdiff1d(needed, self._facets)) > 0:
            self._facets = np.union1d(needed, _expected_facets(problem, iterate))
        if self.store.part(problem, self._facets) is None:
            return Rung.LARGE if len(self._facets) else Rung.UNTOUCHED
        shift = iterate.shift / 4 if iterate.shift > FIRST_SHIFT else 0.0
        while shift < problem.options.last_shift:
            last = Linearisation(
                elasticity=problem.elasticity,
                positions=iterate.positions,
                pressure=iterate.pressure,
                volume_gradient=iterate.elastic.volume_gradient,
                shift=shift,
                facets=self._facets,
            )
            self._body = self._body_of(problem, last)
            if self._body is not None:
                self.linearisation = last
                return self._body
            shift = max(FIRST_SHIFT, 4 * shift)
        return Rung.INDEFINITE

    def _body_of(self, problem: Problem, linearisation: Linearisation) -> Body | None:
        factor = self.store.factor(problem, linearisation)
        if factor is None:
            return None
        self._part, condenser, stiffness = factor
        return Body(problem, condenser, stiffness, shift=linearisation.shift)


def _expected_facets(problem: Problem, iterate: Iterate) -> Index:
    """Facets that may come into contact before long; below a large face only those that are about to."""
    near_mm = float(np.clip(NEAR_EDGES * problem.elasticity.lattice.smallest_edge_mm, *NEAR_MM))
    facets = near_facets(problem.face, iterate, near_mm)
    return near_facets(problem.face, iterate, NEAR_MM[0]) if is_large(problem.face, facets) else facets


def remaining_steps(before: Sequence[float], residual: float, wanted: float) -> float:
    """How many iterations convergence will take if they go on as the last ones did; infinite where they do not.

    Residuals before the last steps are none where they are not known, and nothing is said against them. Good steps of a
    learning model and poor ones alternate, so two tell more than one.
    """
    if len(before) == 0:
        return 0.0
    if residual >= before[0]:
        return np.inf
    return max(0.0, len(before) * float(np.log(residual / wanted) / np.log(before[0] / residual)))


def _step(
    problem: Problem, part: FacePart, body: Body, surface: Surface, iterate: Iterate, predictor: Surface | None
) -> Iterate | None:
    """The state after a step with a model; None where the face cannot be solved with it."""
    stiffness, load = body.at(iterate)
    held = problem.pattern.held[part.unknowns]
    face_problem = FaceProblem(
        whole=problem,
        face=part.face,
        positions=iterate.positions[part.nodes],
        stiffness=stiffness,
        load=load,
        held=held,
        surface=surface,
        touched=TouchedMatrix(stiffness, held),
    )
    solution = solve_face(face_problem, part.memory(iterate.memory), accuracy=iterate.residual, predictor=predictor)
    if solution is None or not np.abs(solution[0]).max() < LONGEST_MM:
        return None
    motion, memory = solution
    moved = body.step(iterate, motion, partial(held_stiffness, face_problem, motion, memory))
    nodes = np.zeros_like(iterate.positions)
    nodes[: problem.pattern.size // 3] = moved.reshape(-1, 3)
    memory = part.put_back(memory, iterate.memory)
    start = replace(iterate, memory=memory, contact=remembered(problem.face, iterate.contact, memory, problem.law))
    end = search(problem, surface, start, nodes, is_stiffened=body.shift > 0)
    return replace(end, iteration=iterate.iteration + 1, shift=body.shift)
