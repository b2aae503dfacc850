"""One load step: iterations on one pose of the object, from an equilibrium under it in another.

They begin on the object's surface carried along from its last pose (`contact.augmented.moved_surface`) where it goes
a long way, so that the face follows the object before the true surface decides.

**Plain Newton steps.** The volumetric stress of each cell is an independent unknown, condensed out: the matrix keeps
its size, the right-hand side is that of the displacement problem, and the stress follows its own linearised law.
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

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import (
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
from magicsim.deform.solve.condensed import Condenser
from magicsim.deform.solve.descent import search, stiffenings
from magicsim.deform.solve.iterate import Iterate, evaluated
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import Problem
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose

# Numbers without a source are assumed: they decide how soon an equilibrium is found, not which one is accepted.
SHORT = 0.25
"""Way of the object, in units of its smallest feature, below which no point of the face changes its side of a tip."""
TABLE_UPDATES, TABLE_PATIENCE = 30, 6
"""Most updates of the limits of friction below a block on a table in one load step, and how many of them are early."""
TABLE_RESIDUALS = (0.3, 1e-2)
"""Residuals below which they are updated, early and late; updated in balance only, a base that was held too little has
slid out and has to be pulled back."""


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


def newton_step(problem: Problem, surface: Surface, iterate: Iterate) -> Iterate:
    """Updates of multipliers and friction limits where they are due, and one Newton step."""
    memory = updated_memory(
        problem.options, problem.law, iterate.memory, iterate.contact, iterate.residual, iterate.mismatch,
        is_late=iterate.iteration >= problem.options.patience,
    )  # fmt: skip
    if memory is not iterate.memory:
        contact = evaluate_contact(problem.face, iterate.positions, surface, memory, problem.law)
        iterate = replace(iterate, memory=memory, contact=contact)
    direction = _direction(problem, surface, iterate)
    if direction is None:
        return replace(iterate, stuck=True, iteration=iterate.iteration + 1)
    motion, shift, is_stiffened = direction
    end = search(problem, surface, iterate, motion, is_stiffened=is_stiffened)
    rungs = (Rung.PLAIN, Rung.SHIFTED) if shift > 0 else (Rung.PLAIN,)
    return replace(end, iteration=iterate.iteration + 1, shift=shift).on(*rungs)


def _direction(problem: Problem, surface: Surface, iterate: Iterate) -> tuple[Array, float, bool] | None:
    """Newton direction of the nodes, shape (nodes, 3) [mm], the shift in its matrix, and whether that is stiffened.

    None where no shift makes the matrix definite.
    """
    options, free = problem.options, problem.elasticity.lattice.free_nodes
    right = problem.free_forces(iterate.contact.node_force_n - iterate.elastic.gradient).ravel()
    attempts = stiffenings(
        first=options.first_shift,
        growth=4.0,
        last=options.last_shift,
        cautious=problem.cautious,
        is_near=iterate.residual < options.update_residual,
        shift=iterate.shift / 4 if iterate.shift > options.first_shift / 4 else 0.0,
    )
    for limit, shift in attempts:
        values = problem.elasticity.hessian(
            iterate.positions, iterate.pressure, iterate.elastic.volume_gradient, problem.pattern, shift=shift
        )
        local = contact_stiffness(
            iterate.contact, problem.face, surface, iterate.memory, problem.law, curvature_limit=limit,
            is_secant=iterate.shortened,
        )  # fmt: skip
        add_sparse_stiffness(values, problem.face, iterate.contact.acting, local, problem.pattern)
        problem.pattern.hold(values)
        if problem.solver.factorise(values):
            motion = np.zeros_like(iterate.positions)
            motion[:free] = problem.solver.solve(right).reshape(-1, 3)
            is_stiffened = shift > 0 or limit == problem.cautious or iterate.shortened
            return (motion, shift, is_stiffened) if np.isfinite(motion).all() else None
    return None


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
    """Where the iterations on a pose end, begun at the last equilibrium, with the object there and where it is now."""
    problem = problem.on_table(start.table)
    nodes, surface = problem.elasticity.lattice.nodes_mm, indenter.distance
    positions, moved = nodes + start.displacements_mm, moved_surface(indenter, before)
    memory = _first_memory(problem, indenter, start)
    way_mm = way_length_mm(before.pose, indenter.pose, reach_mm(start, before.pose))
    is_short = way_mm < SHORT * indenter.shape.feature_mm
    condenser.begin(start.linearisation if may_use_path else None)
    iterate = condenser.step(
        problem,
        surface,
        evaluated(problem, surface, positions, start.pressure_mpa, memory),
        predictor=None if is_short else moved,
        pressed=np.flatnonzero(start.contact_pressure_mpa > 0),
    )
    if isinstance(iterate, Rung):
        state = evaluated(problem, moved, positions, start.pressure_mpa, memory)
        iterate = newton_step(problem, moved, state).on(iterate)
        if not iterate.stuck:
            there = evaluated(problem, surface, iterate.positions, iterate.pressure, iterate.memory)
            iterate = replace(there, iteration=iterate.iteration, shift=iterate.shift, rungs=iterate.rungs)
    note(iterate)
    updates = 0
    while True:
        near = TABLE_RESIDUALS[updates >= TABLE_PATIENCE]
        if iterate.residual <= near and updates < TABLE_UPDATES and not has_settled(iterate.elastic.table):
            problem, updates = problem.with_table_at(iterate.positions), updates + 1
            again = evaluated(problem, surface, iterate.positions, iterate.pressure, iterate.memory)
            iterate = replace(again, rungs=iterate.rungs)
        gave_up = iterate.stuck or iterate.iteration >= problem.options.max_iterations
        if gave_up or not np.isfinite(iterate.residual) or has_converged(problem, iterate):
            return iterate
        step = condenser.step(problem, surface, iterate)
        iterate = newton_step(problem, surface, iterate).on(step) if isinstance(step, Rung) else step
        note(iterate)


def _first_memory(problem: Problem, indenter: Indenter, start: Deformation) -> ContactMemory:
    """Multipliers of zero, see above; anchors move with the object, and limits are those of the last pressures."""
    return ContactMemory(
        multipliers_mpa=np.zeros(len(start.contact_points_mm)),
        penalty=problem.first_penalty,
        anchors_mm=start.contact_points_mm if start.is_rest else indenter.pose.to_sensor(start.anchors_mm),
        limit_mpa=problem.law.friction * start.contact_pressure_mpa,
        normal=indenter.distance(start.contact_points_mm)[1],
    )
