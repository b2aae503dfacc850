"""Contact of an object with a linearised body: a small dense problem on the nodes near the object.

    minimise  1/2 u S u - y u + W(x + u)

with the condensed stiffness S, the load y and the contact's augmented energy W. Newton's method with a line search;
whenever its residual is small, multipliers and friction limits follow the pressures, until both hold.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import (
    ContactState,
    Surface,
    add_dense_stiffness,
    contact_stiffness,
    evaluate_contact,
    slip_mismatch,
    updated_memory,
)
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.solve.descent import decreases, shortened, stiffenings
from magicsim.deform.solve.face_part import LARGE, TouchedMatrix
from magicsim.deform.solve.problem import Problem

# Numbers without a source are assumed: they decide how soon an equilibrium is found, not which one is accepted.
ITERATIONS = 60
"""Most Newton steps of one problem."""
HALVINGS = 12
"""Most shortenings of one of them."""
UPDATES, REPRIEVE = 24, 6
"""Updates of the multipliers in a load step, cheap here, before the penalty is raised; and before it is raised
again."""
MISFIT_SHARE, MISMATCH_SHARE = 0.2, 0.5
"""Misfits and friction limits are brought below these parts of their tolerances: steps are cheap here, and forces are
then smooth in the object's motion."""
GROWTH_SHARE = 0.95
"""Part of the tolerance below which a misfit does not raise the penalty."""
RESIDUALS, RESIDUAL_PACE = (1e-10, 1e-3), 1e-3
"""Residuals that are asked for: the body's own times the pace, within these."""
ROUGH, ROUGH_ITERATIONS = 1e-2, 10
"""Residual of a predicted motion, and most Newton steps towards it."""
MOST_SHIFTED = 2
"""Newton steps in a row of a large face that may need a shift: its body is not one that this way leads on from."""
NOISE = 1e-10
"""Relative rounding of the energy."""
FIRST_SHIFT, SHIFT_GROWTH, LAST_SHIFT = 1e-3, 10.0, 1e3
"""Multiples of the mean diagonal added to a matrix that is not positive definite: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FaceProblem:
    """Body, face and object, which do not change while contact settles; node vectors are of shape (nodes, 3)."""

    whole: Problem
    """The lattice, its law of contact and its tolerances."""
    face: ContactFace
    """The part of the face that may come into contact."""
    positions: Array
    """Where the nodes stand before the step [mm]."""
    stiffness: Array
    """Condensed, shape (3 nodes, 3 nodes) [N/mm]."""
    load: Array
    """Condensed forces without contact, shape (3 nodes,) [N]."""
    held: npt.NDArray[np.bool_]
    """Unknowns that stay zero, shape (3 nodes,)."""
    surface: Surface
    touched: TouchedMatrix
    """Solves with the stiffness and the contact's own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Point:
    """A trial motion of the nodes, with what belongs to it."""

    motion: Array
    contact: ContactState
    unbalanced: Array
    energy_mj: float
    residual: float
    mismatch: float


def solve_face(
    problem: FaceProblem, memory: ContactMemory, *, accuracy: float, predictor: Surface | None = None
) -> tuple[Array, ContactMemory] | None:
    """Motion of the nodes, shape (3 nodes,) [mm], and the memory of contact that belongs to it; None where it fails."""
    whole = problem.whole.options
    options = replace(
        whole, tolerance_mm=whole.tolerance_mm * MISFIT_SHARE, harmless_misfit_mm=GROWTH_SHARE * whole.tolerance_mm,
        slip_mismatch=whole.slip_mismatch * MISMATCH_SHARE, multiplier_updates=UPDATES, reprieve=REPRIEVE,
    )  # fmt: skip
    target = float(np.clip(RESIDUAL_PACE * accuracy, *RESIDUALS))
    start = np.zeros(len(problem.load))
    if predictor is not None:
        start = _predicted(replace(problem, surface=predictor), memory)
    point = _evaluated(problem, start, memory)
    was_cut, shifted = False, 0
    for iteration in range(ITERATIONS):
        updated = updated_memory(
            options, problem.whole.law, memory, point.contact, point.residual, point.mismatch, is_late=True
        )
        if updated is not memory:
            memory = updated
            point = _evaluated(problem, point.motion, memory)
        elif point.residual <= target:
            break
        step, shift = _newton_step(problem, point, memory, is_secant=was_cut)
        shifted = shifted + 1 if shift > 0 else 0
        if step is None or (len(problem.load) > LARGE and shifted > MOST_SHIFTED):
            return None
        end, alpha = _line_search(problem, point, step, memory)
        if end is None:
            if iteration == 0 and predictor is None:
                return None
            break
        point, was_cut = end, alpha < 1
    return (point.motion, memory) if np.isfinite(point.motion).all() else None


def held_stiffness(problem: FaceProblem, motion: Array, memory: ContactMemory) -> Array:
    """Stiffness of contact after a motion of the nodes, positive semidefinite, shape (3 nodes, 3 nodes) [N/mm]."""
    nodes = problem.positions + motion.reshape(-1, 3)
    contact = evaluate_contact(problem.face, nodes, problem.surface, memory, problem.whole.law)
    local = contact_stiffness(contact, problem.face, problem.surface, memory, problem.whole.law, curvature_limit=0.0)
    matrix = np.zeros_like(problem.stiffness)
    add_dense_stiffness(matrix, problem.face, contact.acting, local)
    return matrix


def _predicted(problem: FaceProblem, memory: ContactMemory) -> Array:
    """A rough motion, shape (3 nodes,) [mm]; none where the surface cannot be followed."""
    point, was_cut = _evaluated(problem, np.zeros(len(problem.load)), memory), False
    for _ in range(ROUGH_ITERATIONS):
        if point.residual < ROUGH:
            break
        step, _ = _newton_step(problem, point, memory, is_secant=was_cut)
        end, alpha = (None, 0.0) if step is None else _line_search(problem, point, step, memory)
        if end is None:
            break
        point, was_cut = end, alpha < 1
    return point.motion


def _evaluated(problem: FaceProblem, motion: Array, memory: ContactMemory) -> _Point:
    nodes = problem.positions + motion.reshape(-1, 3)
    contact = evaluate_contact(problem.face, nodes, problem.surface, memory, problem.whole.law)
    force = np.where(problem.held, 0.0, contact.node_force_n.ravel())
    stretched = problem.stiffness @ motion
    unbalanced = problem.load + force - stretched
    size = max(problem.whole.least_force_n, float(np.linalg.norm(force)))
    return _Point(
        motion=motion,
        contact=contact,
        unbalanced=unbalanced,
        energy_mj=float(motion @ (stretched / 2 - problem.load)) + contact.energy_mj,
        residual=float(np.linalg.norm(unbalanced)) / size,
        mismatch=slip_mismatch(problem.face, contact, memory, problem.whole.law),
    )


def _newton_step(
    problem: FaceProblem, point: _Point, memory: ContactMemory, *, is_secant: bool
) -> tuple[Array | None, float]:
    """Motion, and the shift that its matrix needed; none where no shift makes the matrix definite."""
    is_near = point.residual < problem.whole.options.update_residual
    diagonal = float(np.abs(np.diagonal(problem.stiffness)).mean())
    for limit, shift in stiffenings(
        first=FIRST_SHIFT, growth=SHIFT_GROWTH, last=LAST_SHIFT, cautious=problem.whole.cautious, is_near=is_near
    ):
        local = contact_stiffness(
            point.contact, problem.face, problem.surface, memory, problem.whole.law, curvature_limit=limit,
            is_secant=is_secant,
        )  # fmt: skip
        if shift == 0:
            step = problem.touched.solve(problem.face, point.contact.acting, local, point.unbalanced)
            if step is not None:
                return step, 0.0
            continue
        matrix = problem.stiffness.copy()
        add_dense_stiffness(matrix, problem.face, point.contact.acting, local)
        matrix[problem.held], matrix[:, problem.held] = 0.0, 0.0
        matrix[np.diag_indices_from(matrix)] += np.where(problem.held, 1.0, shift * diagonal)
        try:
            factor = cho_factor(matrix, overwrite_a=True, check_finite=False)
        except LinAlgError:
            continue
        return np.asarray(cho_solve(factor, point.unbalanced)), shift
    return None, np.inf


def _line_search(
    problem: FaceProblem, start: _Point, step: Array, memory: ContactMemory
) -> tuple[_Point | None, float]:
    slope = -float(start.unbalanced @ step)
    noise = NOISE * (abs(start.energy_mj) + abs(start.contact.energy_mj))

    def trial(alpha: float) -> _Point:
        return _evaluated(problem, start.motion + alpha * step, memory)

    def accepts(end: _Point, alpha: float) -> bool:
        return decreases(end.energy_mj, start.energy_mj, alpha * slope, noise)

    end, alpha, is_accepted = shortened(accepts, trial, longest=1.0, halvings=HALVINGS)
    return (end, alpha) if is_accepted else (None, 0.0)
