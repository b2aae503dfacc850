"""One load step: iterations on one pose of the object, from an equilibrium under it in another.

They begin on the object's surface carried along from its last pose (`contact.augmented.moved_surface`) where it goes
a long way, so that the face follows the object before the true surface decides.

**Plain Newton steps.** The volumetric stress of each cell is an independent unknown, condensed out: the matrix keeps
its size, the right- hand side is that of the displacement problem, and the stress follows its own linearised law.
Iteration counts then do not grow as nu approaches 1/2.

Every load step begins with contact multipliers of zero, a plain penalty problem whose energy changes little from
pose to pose; only where it is penetrated deeper than the tolerance are multipliers updated, as soon as the residual
is small, so an update costs an iteration and not a solve. Multipliers carried from pose to pose would be warmer, but
they keep more points in contact than the lattice can follow, and its energy then has minima without number. The limits
of friction are updated along the way likewise.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from magicsim.deform.contact.augmented import (
    Patience,
    Surface,
    add_sparse_stiffness,
    contact_stiffness,
    evaluate_contact,
    moved_surface,
    updated_memory,
)
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.table import has_settled
from magicsim.deform.solve.condensed import Condenser, FirstStep
from magicsim.deform.solve.descent import Direction, Shifts, search, stiffenings
from magicsim.deform.solve.iterate import Iterate, evaluated
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import NewtonOptions, Problem
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose


def first_contact(indenter: Indenter) -> Pose:
    """The pose lowered until the object's highest point is level with the undeformed face."""
    return replace(indenter.pose, position_mm=indenter.pose.position_mm - [0.0, 0.0, indenter.top_mm()])


def way_length_mm(first: Pose, last: Pose, reach_mm: float) -> float:
    """Length of the way of the object's origin and of its points at a distance from the vertical through it [mm]."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).magnitude()
    return float(np.linalg.norm(last.position_mm - first.position_mm) + turn * reach_mm)


def reach_mm(state: Deformation, pose: Pose) -> float:
    """Largest distance of a pressed point of a state from the vertical through an object's origin [mm]."""
    touching = state.contact_points_mm[state.contact_pressure_mpa > 0] - pose.position_mm
    return float(np.linalg.norm(touching[:, :2], axis=1).max(initial=0.0))


def pose_between(first: Pose, last: Pose, share: float) -> Pose:
    """Pose on the straight way, turning about one axis."""
    turn = Rotation.from_matrix(last.rotation @ first.rotation.T).as_rotvec()
    rotation = Rotation.from_rotvec(share * turn).as_matrix() @ first.rotation
    return Pose(position_mm=(1 - share) * first.position_mm + share * last.position_mm, rotation=rotation)


def is_there(indenter: Indenter, state: Deformation) -> bool:
    """Whether a state is the equilibrium under this very object in this very pose, known by every gap."""
    if state.pose is None or not np.array_equal(state.pose.position_mm, indenter.pose.position_mm):
        return False
    gap = indenter.distance(state.contact_points_mm)[0]
    return np.array_equal(state.pose.rotation, indenter.pose.rotation) and np.array_equal(gap, state.contact_gap_mm)


def has_converged(problem: Problem, iterate: Iterate) -> bool:
    """Whether forces balance, contact holds where pressure is, friction keeps to its limit and no cell is folded."""
    return (
        iterate.residual <= problem.options.residual
        and iterate.mismatch <= problem.options.slip_mismatch
        and iterate.contact.misfit_mm <= problem.options.tolerance_mm
        and iterate.elastic.min_jacobian > 0
    )


def terminate(problem: Problem, iterate: Iterate) -> bool:
    """Whether to stop: converged, stuck, not finite or out of iterations."""
    gave_up = iterate.stuck or iterate.iteration >= problem.options.max_iterations
    return gave_up or not np.isfinite(iterate.residual) or has_converged(problem, iterate)


def newton_step(problem: Problem, surface: Surface, iterate: Iterate) -> Iterate:
    """Updates of multipliers and friction limits where they are due, and one Newton step."""
    memory = updated_memory(
        _patience(problem.options, iterate.iteration), problem.law, iterate.memory, iterate.contact, iterate.residual,
        iterate.mismatch,
    )  # fmt: skip
    if memory is not iterate.memory:
        contact = evaluate_contact(problem.face, iterate.positions, surface, memory, problem.law)
        iterate = replace(iterate, memory=memory, contact=contact)
    direction = _direction(problem, surface, iterate)
    if direction is None:
        return replace(iterate, stuck=True, iteration=iterate.iteration + 1)
    found = search(problem, surface, iterate, direction)
    rungs = (Rung.PLAIN, Rung.SHIFTED) if direction.shift > 0 else (Rung.PLAIN,)
    return replace(found, iteration=iterate.iteration + 1, shift=direction.shift).on(*rungs)


def _patience(options: NewtonOptions, iteration: int) -> Patience:
    is_relaxed = iteration >= options.patience
    return Patience(
        misfit_mm=options.tolerance_mm,
        mismatch=options.slip_mismatch,
        multiplier_residual=options.update_residual,
        limit_residual=options.limit_residual[is_relaxed],
        is_relaxed=is_relaxed,
        updates=options.multiplier_updates,
        growth=options.penalty_growth,
    )


def _direction(problem: Problem, surface: Surface, iterate: Iterate) -> Direction | None:
    """Newton direction of the free nodes; None where no shift makes the matrix definite."""
    options, free = problem.options, problem.elasticity.lattice.free_nodes
    right = problem.free_forces(iterate.contact.node_force_n - iterate.elastic.gradient).ravel()
    cautious = problem.stiffness / 4
    shifts = Shifts(first=options.first_shift, growth=4.0, last=options.last_shift)
    before = iterate.shift / 4 if iterate.shift > options.first_shift / 4 else 0.0
    is_near = iterate.residual < options.update_residual
    for tried in stiffenings(shifts, cautious=cautious, is_near=is_near, shift=before):
        values = problem.elasticity.hessian(
            iterate.positions, iterate.pressure, iterate.elastic.volume_gradient, problem.pattern, shift=tried.shift
        )
        local = contact_stiffness(
            iterate.contact, problem.face, surface, iterate.memory, problem.law, curvature_limit=tried.curvature_limit,
            is_secant=iterate.shortened,
        )  # fmt: skip
        add_sparse_stiffness(values, problem.face, iterate.contact.acting, local, problem.pattern)
        problem.pattern.hold(values)
        if problem.solver.factorise(values):
            nodes = np.zeros_like(iterate.positions)
            nodes[:free] = problem.solver.solve(right).reshape(-1, 3)
            if not np.isfinite(nodes).all():
                return None
            is_stiffened = tried.shift > 0 or tried.curvature_limit == cautious or iterate.shortened
            return Direction(nodes=nodes, shift=tried.shift, is_stiffened=is_stiffened)
    return None


SHORT = 0.25
"""Way of the object, in units of its smallest feature, below which no point of the face changes its side of a tip."""
TABLE_UPDATES, TABLE_PATIENCE = 30, 6
"""Most updates of the limits of friction below a block on a table in one load step, and how many of them are early."""
TABLE_RESIDUALS = (0.3, 1e-2)
"""Residuals below which they are updated, early and late; updated in balance only, a base that was held too little has
slid out and has to be pulled back."""


def iterate_pose(
    problem: Problem,
    condenser: Condenser,
    indenter: Indenter,
    before: Indenter,
    start: Deformation,
    *,
    may_use_path: bool,
    note: Callable[[Iterate], None],
) -> Iterate:
    """Where the iterations on a pose end.

    Args:
        problem: The lattice, its tolerances and limits.
        condenser: Takes the steps.
        indenter: The object in its pose.
        before: The object in the pose of the last equilibrium.
        start: That equilibrium.
        may_use_path: Whether the factor that the path has left is used.
        note: Told every iteration.
    """
    problem = problem.on_table(start.table)
    nodes, pressed = problem.elasticity.lattice.nodes_mm, np.flatnonzero(start.contact_pressure_mpa > 0)
    positions, surface = nodes + start.displacements_mm, moved_surface(indenter, before)
    memory = _first_memory(problem, indenter, start)
    last = evaluated(problem, indenter.distance, positions, start.pressure_mpa, memory)
    way_mm = way_length_mm(before.pose, indenter.pose, reach_mm(start, before.pose))
    is_short = way_mm < SHORT * indenter.shape.feature_mm
    first = FirstStep(predictor=None if is_short else surface, pressed=pressed)
    condenser.begin(start.linearisation if may_use_path else None)
    found = condenser.step(problem, indenter.distance, last, first=first)
    if isinstance(found, Rung):
        state = evaluated(problem, surface, positions, start.pressure_mpa, memory)
        found = newton_step(problem, surface, state).on(found)
        if not found.stuck:
            guess = evaluated(problem, indenter.distance, found.positions, found.pressure, found.memory)
            found = replace(guess, iteration=found.iteration, shift=found.shift, rungs=found.rungs)
    note(found)
    updates = 0
    while True:
        near = TABLE_RESIDUALS[updates >= TABLE_PATIENCE]
        if found.residual <= near and updates < TABLE_UPDATES and not has_settled(found.elastic.table):
            problem, updates = problem.with_table_at(found.positions), updates + 1
            again = evaluated(problem, indenter.distance, found.positions, found.pressure, found.memory)
            found = replace(again, rungs=found.rungs)
        if terminate(problem, found):
            return found
        following = condenser.step(problem, indenter.distance, found)
        if isinstance(following, Rung):
            following = newton_step(problem, indenter.distance, found).on(following)
        found = following
        note(found)


def _first_memory(problem: Problem, indenter: Indenter, start: Deformation) -> ContactMemory:
    """Multipliers of zero, see above; anchors move with the object, and limits are those of the last pressures."""
    return ContactMemory(
        multipliers_mpa=np.zeros(len(start.contact_points_mm)),
        penalty=problem.first_penalty,
        anchors_mm=start.contact_points_mm if start.is_rest else indenter.pose.to_sensor(start.anchors_mm),
        limit_mpa=problem.law.friction * start.contact_pressure_mpa,
        normal=indenter.distance(start.contact_points_mm)[1],
    )
