"""Poses in sequence: warm starts, sub-steps, the fallbacks of a step that fails, and the check of what comes out.

What is tried where a step fails is in `ladder`; when all of that fails the path is begun again from rest, with longer
steps.
"""

import math
from dataclasses import replace

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import dragged_anchors
from magicsim.deform.contact.face import POINT_SPACING_MM
from magicsim.deform.deformation import Deformation, border_gaps_mm, touching_points
from magicsim.deform.lattice.core_failure import CoreLaw, CoreState, FailingCore
from magicsim.deform.lattice.relaxation import Branches, Relaxation
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import has_settled
from magicsim.deform.overlap import burial_fault, overlap_fault
from magicsim.deform.quality import NewtonOptions
from magicsim.deform.solve.condensed import Condenser
from magicsim.deform.solve.factorise import on_one_blas_thread
from magicsim.deform.solve.iterate import (
    LEAST_LIFT,
    Effort,
    Iterate,
    Progress,
    force_balance,
    lift,
    report,
    report_bound,
    report_passage,
)
from magicsim.deform.solve.ladder import Rung, Strides, rung_names
from magicsim.deform.solve.load_step import (
    first_contact,
    has_converged,
    iterate_pose,
    pose_between,
    reach_mm,
    way_length_mm,
)
from magicsim.deform.solve.problem import Problem
from magicsim.deform.solve.tangent import contact_tangent
from magicsim.errors import ConvergenceError
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose

TOUCHING_SHARE = 0.01
"""Gap, in units of the smallest cell edge, that still counts as contact area: a coarse face leaves such gaps;
assumed."""
RECOVERED_MM = 5e-4
"""A dent below this counts as recovered [mm]: half of what is rendered at all."""
RAISED_MM = 0.05
"""How far below the contact face an object waits that has left it [mm]."""
ROUNDING = 1e-9
EDGE_STEP_SHARE = 0.5
"""Load steps at edges with friction in units of others: in one of 0.5 mm points cross an edge that hold there in
shorter ones (a box of 4 mm turned by 20 degrees: torque 36 % too large, 0.8 % in half of it)."""
SHORTEST_FEATURE_MM = 0.1
"""Objects with smaller features do not shorten the load steps further [mm]."""
MAX_ITERATIONS = 2000
"""Iterations of one equilibrium before a press is given up, all load steps and restarts together. Time is bounded in
work, so that it never decides about a result; the 649 presses of `benchmarks/stress.py` need at most 874."""
FAILURE_STEP_MM, FLOW_ROUNDS, UNSETTLED_SHARE = 0.1, 40, 1e-4
"""Longest way between two states of a core that fails [mm]; most equilibria for one of them, and the share of the
infill's volume that may still flow otherwise: a single point below an edge flips with a point of the face. Assumed."""
TEAR_SHARE, LEAST_TEAR_SHARE = 0.25, 1 / 64
"""Share of walls that is gone first on the way from one equilibrium to the next; the least of a step that is tried
again where none is found: assumed."""
LONGER = 4
"""How much longer the load steps of a path are that is begun again: they do not meet the snaps of a face between the
bumps of a texture at all; assumed."""


def waiting(indenter: Indenter) -> Indenter:
    """An object that has left the face, just clear of it where it is: nothing depends on how far away it is."""
    return _raised(indenter, max(0.0, -RAISED_MM - indenter.top_mm()))


def taken_away(indenter: Indenter) -> Indenter:
    """An object that goes straight down from where it presses until it is as clear of the face."""
    return _raised(indenter, -max(0.0, indenter.top_mm() + RAISED_MM))


def _raised(indenter: Indenter, way_mm: float) -> Indenter:
    position = indenter.pose.position_mm + np.array([0.0, 0.0, way_mm])
    return replace(indenter, pose=replace(indenter.pose, position_mm=position))


class ContactSolver:
    """Solves one lattice for any sequence of objects and poses; keeps the factorisation's analysis."""

    @on_one_blas_thread
    def __init__(
        self,
        lattice: Lattice,
        *,
        tolerance_mm: float = 0.002,
        options: NewtonOptions | None = None,
        max_step_mm: float = 0.5,
        friction: float = 0.0,
        point_spacing_mm: float = POINT_SPACING_MM,
        branches: Branches | None = None,
        recovers: bool = False,
        core: CoreLaw | None = None,
        max_iterations: int = MAX_ITERATIONS,
    ) -> None:
        """Prepares a lattice.

        Args:
            lattice: The block.
            tolerance_mm: Largest penetration at any contact point [mm].
            options: All tolerances and limits of a load step, instead of that one.
            max_step_mm: Longest motion of the object between two load steps [mm], before anything else is tried.
            friction: Coulomb's coefficient between object and face.
            point_spacing_mm: Largest distance between contact points at rest [mm].
            branches: Relaxation of a timed path; None is the quasi-static, long-term response.
            recovers: Whether a dent goes on recovering where nothing touches; it needs branches.
            core: How the core flows and tears, which is remembered. None where it does not; not on a timed path.
            max_iterations: Bound of one equilibrium, see `MAX_ITERATIONS`.
        """
        self.max_iterations = max_iterations
        self.recovers = recovers and branches is not None
        self.lattice = lattice
        self.max_step_mm = max_step_mm
        self._problem = Problem.of(
            lattice,
            options or NewtonOptions(tolerance_mm=tolerance_mm),
            friction=friction,
            point_spacing_mm=point_spacing_mm,
            branches=branches,
        )
        self._relaxation = Relaxation.of(self._problem.elasticity, branches) if branches is not None else None
        self._core = FailingCore(elasticity=self._problem.elasticity, law=core) if core is not None else None
        self._condenser = Condenser()
        rest = Deformation.rest(lattice, self._problem.face)
        self._rest = replace(rest, relaxation=self._relaxation.rest()) if self._relaxation is not None else rest

    @on_one_blas_thread
    def solve(
        self,
        indenter: Indenter,
        previous: Deformation | None = None,
        *,
        dt_s: float = math.inf,
        progress: Progress | None = None,
    ) -> Deformation:
        """Equilibrium with the object in a pose, reached from a previous one or from first contact.

        Args:
            indenter: The object in its pose.
            previous: Where the path stands; None starts from rest.
            dt_s: Time since then, for a lattice with branches [s].
            progress: Told the share of the way after every iteration, see `Progress`.

        Returns:
            A valid deformation; the rest state, without a solve, when no point of the undeformed face lies inside the
            object or below a part of it, unless a dent recovers there.

        Raises:
            ConvergenceError: No valid equilibrium was found, or none within the bound, or the object lies inside the
                block between the points (see `overlap`); the message has the figures.
        """
        touches = self.can_touch(indenter)
        if not touches:
            self._refuse_overlap(self._rest, indenter)
            if previous is None or previous.pose is None:
                return self._rest
            if not (self.recovers or (previous.core is not None and previous.core.has_failed)):
                return self._rest
            indenter = waiting(indenter)
        elif (buried := burial_fault(self.lattice, indenter)) is not None:
            raise ConvergenceError(buried)
        start = previous if previous is not None and previous.pose is not None else self._rest
        problem, effort = self._timed(start, dt_s), Effort(progress=progress, most=self.max_iterations)
        if self._core is not None:
            failed = self._fail_along(self._core, indenter, start, effort)
            if touches:
                self._refuse_overlap(failed, indenter)
            return failed
        state = self._follow_path(problem, indenter, start, effort)
        is_pathless = problem.law.friction == 0 and self._relaxation is None and self.lattice.table is None
        if state is None and is_pathless:  # an equilibrium that may be sought from rest
            effort.restarts, effort.rungs = 1, frozenset((Rung.FEWER,))
            state = self._follow_path(problem, indenter, self._rest, effort, longer=LONGER)
        if state is None:
            complain = report_passage if self._has_passed_through(effort.last) else report
            raise ConvergenceError(complain(problem, effort))
        if touches:
            self._refuse_overlap(state, indenter)
        elif np.abs(state.displacements_mm).max() < RECOVERED_MM:  # what is left of a dent is next to nothing
            return self._rest
        if self._relaxation is None or start.relaxation is None:
            return state
        positions = self.lattice.nodes_mm + state.displacements_mm
        return replace(state, relaxation=self._relaxation.advanced(start.relaxation, positions, dt_s=dt_s))

    def _fail_along(self, core: FailingCore, indenter: Indenter, start: Deformation, effort: Effort) -> Deformation:
        """The end of a way on which the core fails, step by step: infill flows, then walls tear while nothing moves."""
        first = start.pose or first_contact(indenter)
        count = max(
            1, math.ceil(way_length_mm(first, indenter.pose, reach_mm(start, first)) / FAILURE_STEP_MM - ROUNDING)
        )
        state = start
        for step in range(1, count + 1):
            pose = indenter.pose if step == count else pose_between(first, indenter.pose, step / count)
            moved = replace(indenter, pose=pose)
            now, state = self._flowed(core, moved, state.core or core.rest(), state, effort)
            while (torn := self._torn(core, moved, now, state, effort)) is not None:
                now, state = torn
            state = replace(state, core=now)
        return state

    def _torn(
        self, core: FailingCore, indenter: Indenter, before: CoreState, start: Deformation, effort: Effort
    ) -> tuple[CoreState, Deformation] | None:
        """The equilibrium after the next walls have torn while the object stays; None where all hold."""
        places, now, state = self.lattice.nodes_mm + start.displacements_mm, before, start
        cells = core.next_torn(before, places)
        if len(cells) == 0:
            return None
        gone, step = 0.0, TEAR_SHARE
        while gone < 1:
            torn = before.torn.copy()
            torn[cells] = share = min(gone + step, 1.0)
            try:
                now, state = self._flowed(core, indenter, replace(now, torn=torn), state, effort)
            except ConvergenceError:
                step /= 2
                if step < LEAST_TEAR_SHARE:
                    raise
            else:
                gone, step = share, 2 * step
        less = core.stored_nmm(before, places) - core.stored_nmm(now, self.lattice.nodes_mm + state.displacements_mm)
        return replace(now, dissipated_nmm=before.dissipated_nmm + max(less, 0.0)), state  # below 0 by rounding alone

    def _flowed(
        self, core: FailingCore, indenter: Indenter, before: CoreState, start: Deformation, effort: Effort
    ) -> tuple[CoreState, Deformation]:
        """An equilibrium and the core that fits it, found by turns; what is torn stays as it is."""
        now = before
        for _ in range(FLOW_ROUNDS):
            problem = replace(self._problem, elasticity=core.at(now))
            # from the same start in every round: friction would go on slipping from one to the next
            found = self._follow_path(problem, indenter, start, effort)
            if found is None:
                raise ConvergenceError(report(problem, effort))
            last, now = now, core.flowed(before, self.lattice.nodes_mm + found.displacements_mm)
            if core.unsettled(last, now) <= UNSETTLED_SHARE:
                return now, replace(found, core=now)
        raise ConvergenceError(f"the infill's flow does not converge in {FLOW_ROUNDS} equilibria of one step")

    def _refuse_overlap(self, state: Deformation, indenter: Indenter) -> None:
        """Raises ConvergenceError where the object lies inside the block between its contact points."""
        fault = overlap_fault(self.lattice, self._problem.face, state, indenter)
        if fault is not None:
            raise ConvergenceError(fault)

    def _timed(self, start: Deformation, dt_s: float) -> Problem:
        """The problem of one time step: the branches make it another elastic one."""
        if self._relaxation is None or start.relaxation is None:
            return self._problem
        elasticity = self._relaxation.timed_elasticity(start.relaxation, dt_s=dt_s)
        return replace(self._problem, elasticity=elasticity)

    def can_touch(self, indenter: Indenter) -> bool:
        """Whether any point of the undeformed contact face lies inside the object or below a part of it."""
        points = self._rest.contact_points_mm
        return any(
            (indenter.distance(points + np.array([0.0, 0.0, level]))[0] < 0).any() for level in indenter.levels_mm()
        )

    @on_one_blas_thread
    def tangent(self, state: Deformation, indenter: Indenter) -> Array | None:
        """How force and torque change with a small motion of the object, shape (6, 6), see `contact_tangent`."""
        return contact_tangent(self._problem, self._condenser.store, state, indenter)

    @property
    def face_mm(self) -> Array:
        """Contact points of the undeformed face, shape (points, 3) [mm]."""
        return self._rest.contact_points_mm

    @property
    def factorisations(self) -> int:
        """How many matrices this solver has factorised with the contact condensed."""
        return self._condenser.store.factorisations

    def force_within_n(self, state: Deformation, centre_mm: tuple[float, float], radius_mm: float) -> Array:
        """Force on the points of the face that lie, deformed, within a distance of a vertical axis, shape (3,) [N]."""
        offset = state.contact_points_mm[:, :2] - np.array(centre_mm)
        inside = np.flatnonzero(np.hypot(offset[:, 0], offset[:, 1]) < radius_mm)
        return np.asarray(self._problem.face.area_mm2[inside] @ state.contact_traction_mpa[inside])

    def _follow_path(
        self, problem: Problem, indenter: Indenter, start: Deformation, effort: Effort, *, longer: float = 1
    ) -> Deformation | None:
        first = start.pose or first_contact(indenter)
        reach = reach_mm(start, first)
        longest = min(self.max_step_mm, max(indenter.shape.feature_mm, SHORTEST_FEATURE_MM)) * longer
        if problem.is_at_edges and problem.law.friction > 0:
            longest *= EDGE_STEP_SHARE
        count = max(1, int(np.ceil(way_length_mm(first, indenter.pose, reach) / longest - 1e-9)))
        state, pose = start, first
        strides = Strides(usual=1.0 / count)
        before_cutbacks = effort.cutbacks
        while strides.done < 1 and not strides.gave_up:
            if effort.iterations >= effort.most:
                face, sides = self.lattice.face, self.lattice.footprint_mm
                places = (replace(indenter, pose=each) for each in (pose, indenter.pose))
                depths = (max(0.0, place.depth_mm(face, sides)) for place in places)
                raise ConvergenceError(report_bound(problem, effort, effort.most, *depths))
            target, effort.share = strides.target, strides.done
            next_pose = indenter.pose if target == 1 else pose_between(first, indenter.pose, target)
            moved, before = (replace(indenter, pose=each) for each in (next_pose, pose))
            iterate = iterate_pose(
                problem.with_care() if strides.is_careful else problem,
                self._condenser,
                moved,
                before,
                state,
                may_use_path=not strides.is_careful,
                note=effort.note,
            )
            if self._is_valid(problem, iterate, moved):
                effort.rungs |= iterate.rungs | strides.rungs
                state, pose = self._result(problem, iterate, next_pose, effort), next_pose
                strides.succeed()
            else:
                effort.last = iterate
                strides.fail()
                effort.cutbacks = before_cutbacks + strides.cutbacks
        return None if strides.gave_up else state

    def _is_valid(self, problem: Problem, iterate: Iterate, indenter: Indenter) -> bool:
        return (
            has_converged(problem, iterate)
            and force_balance(problem, iterate) <= problem.options.largest_balance
            and has_settled(iterate.elastic.table)
            and not (self._has_passed_through(iterate) and self.can_touch(indenter))
        )

    def _has_passed_through(self, iterate: Iterate | None) -> bool:
        """Whether nothing presses back, as around an object that has pierced the face: not an answer below an object.

        On a timed path it is one, a dent that still recovers, and so it is where a core has failed.
        """
        return (
            self._relaxation is None
            and self._core is None
            and iterate is not None
            and lift(self._problem, iterate) <= LEAST_LIFT
        )

    def _result(self, problem: Problem, iterate: Iterate, pose: Pose, effort: Effort) -> Deformation:
        contact, face = iterate.contact, problem.face
        traction = contact.traction_mpa()
        forces = face.area_mm2[:, None] * traction
        friction = np.linalg.norm(contact.shear_mpa, axis=1)
        tolerance = problem.options.tolerance_mm
        limits = border_gaps_mm(self.lattice, face, contact.points_mm, contact.normal)
        limits[limits == 0] = max(tolerance, TOUCHING_SHARE * self.lattice.smallest_edge_mm)
        pressed = np.where(contact.pressure_mpa > 0, np.inf, limits)
        touching = touching_points(self.lattice, face, contact.points_mm, contact.gap_mm, gap_limits_mm=pressed)
        limits = np.where(touching, np.maximum(limits, contact.gap_mm), limits)
        return Deformation(
            displacements_mm=iterate.positions - self.lattice.nodes_mm,
            pressure_mpa=iterate.pressure,
            anchors_mm=pose.to_object(dragged_anchors(contact, iterate.memory, problem.law)),
            contact_points_mm=contact.points_mm,
            contact_pressure_mpa=contact.pressure_mpa,
            contact_traction_mpa=traction,
            is_slipping=(contact.pressure_mpa > 0)
            & (friction > 0)
            & (friction >= (1 - ROUNDING) * iterate.memory.limit_mpa),
            contact_gap_mm=contact.gap_mm,
            touches_within_mm=limits,
            linearisation=self._condenser.linearisation,
            pose=pose,
            force_n=forces.sum(0),
            torque_nmm=np.cross(contact.points_mm, forces).sum(0),
            contact_area_mm2=float(face.current_area_mm2(iterate.positions, np.flatnonzero(touching)).sum()),
            max_penetration_mm=contact.max_penetration_mm,
            min_jacobian=iterate.elastic.min_jacobian,
            force_balance=force_balance(problem, iterate),
            iterations=effort.iterations,
            cutbacks=effort.cutbacks,
            restarts=effort.restarts,
            rungs=rung_names(effort.rungs),
            shifted=effort.shifted,
            unknowns=problem.pattern.size,
            table=iterate.elastic.table.memory if iterate.elastic.table is not None else None,
        )
