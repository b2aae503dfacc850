"""One load step: primal-dual Newton iterations for a fixed pose of the object.

The volumetric stress of each cell is an independent unknown, condensed out: the matrix keeps its size, the right-
hand side is that of the displacement problem, and the stress follows its own linearised law. Iteration counts then
do not grow as nu approaches 1/2.

Every load step begins with contact multipliers of zero, a plain penalty problem whose energy changes little from
pose to pose; only where it is penetrated deeper than the tolerance are multipliers updated, as soon as the residual
is small, so an update costs an iteration and not a solve. Multipliers carried from pose to pose would be warmer, but
they keep more points in contact than the lattice can follow, and its energy then has minima without number. The limits
of friction are updated along the way likewise.
"""

from dataclasses import replace

import numpy as np

from magicsim.deform.contact.augmented import Surface, add_sparse_stiffness, contact_stiffness, evaluate_contact
from magicsim.deform.contact.patience import Patience, updated_memory
from magicsim.deform.solve.descent import Shifts, stiffenings
from magicsim.deform.solve.iterate import Iterate
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.line_search import Direction, search
from magicsim.deform.solve.problem import NewtonOptions, Problem


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


def step(problem: Problem, surface: Surface, iterate: Iterate) -> Iterate:
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
