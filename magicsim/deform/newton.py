"""One load step: primal-dual Newton iterations for a fixed pose of the object.

The volumetric stress of each cell is an independent unknown, condensed out: the matrix keeps its size, the right-
hand side is that of the displacement problem, and the stress follows its own linearised law. Iteration counts then
do not grow as nu approaches 1/2. The contact multipliers are updated along the way as soon as the residual is
small, so an augmented Lagrangian update costs an iteration and not a solve.

Safeguard: a step is shortened until every Gauss point keeps a positive Jacobian and until the energy with the new
stresses as multipliers (its volume term bounded, so that stiffness in volume does not throttle the step) has
decreased.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.deform.contact import ContactState, add_contact_stiffness, evaluate_contact
from magicsim.deform.energy import Elasticity, ElasticState
from magicsim.deform.face import ContactFace
from magicsim.deform.linear import SymmetricSolver
from magicsim.deform.pattern import BlockPattern
from magicsim.geometry.indenter import Indenter

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class NewtonOptions:
    """When to stop, and how far one step may go."""

    tolerance_mm: float = 0.002
    """Largest penetration accepted."""
    residual: float = 1e-8
    """Largest norm of the out-of-balance nodal forces over that of the contact forces."""
    update_residual: float = 1e-2
    """Residual below which contact multipliers are updated."""
    penalty_ratio: float = 200.0
    """Contact penalty in units of `Problem.stiffness`."""
    step_ratio: float = 0.7
    """Longest step of a node in units of the smallest cell edge."""
    first_shift: float = 0.25
    """Multiple of the spring Laplacian added to a matrix that is not positive definite; four times more each try."""
    last_shift: float = 1e4
    """Multiple at which to give up."""
    max_iterations: int = 40
    """Iterations before the load step is given up."""
    max_halvings: int = 10
    """Shortenings of one Newton step."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """What does not change along a path."""

    elasticity: Elasticity
    face: ContactFace
    pattern: BlockPattern
    solver: SymmetricSolver
    options: NewtonOptions

    @property
    def smallest_edge_mm(self) -> float:
        """Shortest cell edge [mm]."""
        return float(self.elasticity.lattice.sizes_mm.min())

    @property
    def stiffness(self) -> float:
        """Young's modulus of the skin (nu = 1/2) over the smallest cell edge [N/mm3]."""
        skin = self.elasticity.lattice.shear_modulus_mpa[: len(self.face.patches)].max()
        return float(3 * skin / self.smallest_edge_mm)

    @property
    def penalty(self) -> float:
        """Contact penalty [N/mm3]."""
        return self.options.penalty_ratio * self.stiffness


@dataclass(frozen=True, slots=True, kw_only=True)
class Iterate:
    """State of the Newton iteration, with everything that depends on it already evaluated."""

    positions: Array
    pressure: Array
    multipliers: Array
    elastic: ElasticState
    contact: ContactState
    residual: float
    """Relative norm of the out-of-balance forces."""
    iteration: int
    shift: float
    """Spring Laplacian that the last matrix needed."""
    stuck: bool = False
    """Whether no acceptable step was found."""


def init(problem: Problem, indenter: Indenter, positions: Array, pressure: Array, multipliers: Array) -> Iterate:
    """Evaluates the starting point.

    Args:
        problem: The lattice and its solver.
        indenter: The object in the pose of this load step.
        positions: Node positions, shape (nodes, 3) [mm].
        pressure: Volumetric stress, shape (cells,) [MPa].
        multipliers: Contact multipliers, shape (points,) [MPa].
    """
    elastic = problem.elasticity.evaluate(positions)
    contact = evaluate_contact(problem.face, positions, indenter, multipliers, problem.penalty)
    return Iterate(
        positions=positions,
        pressure=pressure,
        multipliers=multipliers,
        elastic=elastic,
        contact=contact,
        residual=_relative_residual(problem, elastic, contact),
        iteration=0,
        shift=0.0,
    )


def has_converged(problem: Problem, iterate: Iterate) -> bool:
    """Whether forces balance, no point penetrates and no cell is folded."""
    return (
        iterate.residual <= problem.options.residual
        and iterate.contact.max_penetration_mm <= problem.options.tolerance_mm
        and iterate.elastic.min_jacobian > 0
    )


def terminate(problem: Problem, iterate: Iterate) -> bool:
    """Whether to stop: converged, stuck, not finite or out of iterations."""
    gave_up = iterate.stuck or iterate.iteration >= problem.options.max_iterations
    return gave_up or not np.isfinite(iterate.residual) or has_converged(problem, iterate)


def step(problem: Problem, indenter: Indenter, iterate: Iterate) -> Iterate:
    """One multiplier update where it is due, and one Newton step."""
    options = problem.options
    if iterate.residual < options.update_residual and iterate.contact.max_penetration_mm > 0.9 * options.tolerance_mm:
        multipliers = iterate.contact.traction_mpa
        contact = evaluate_contact(problem.face, iterate.positions, indenter, multipliers, problem.penalty)
        iterate = replace(iterate, multipliers=multipliers, contact=contact)
    direction, shift = _direction(problem, indenter, iterate)
    if direction is None:
        return replace(iterate, stuck=True, iteration=iterate.iteration + 1)
    return _search(problem, indenter, replace(iterate, shift=shift), direction)


def _relative_residual(problem: Problem, elastic: ElasticState, contact: ContactState) -> float:
    free = problem.elasticity.lattice.free_nodes
    residual = (elastic.gradient - contact.node_force_n)[:free]
    floor = 1e-6 * float(problem.elasticity.lattice.shear_modulus_mpa.max()) * problem.smallest_edge_mm**2
    return float(np.linalg.norm(residual) / max(floor, float(np.linalg.norm(contact.node_force_n))))


def _direction(problem: Problem, indenter: Indenter, iterate: Iterate) -> tuple[Array | None, float]:
    """Newton direction of the free nodes, shape (nodes, 3), and the shift that made the matrix definite."""
    options, free = problem.options, problem.elasticity.lattice.free_nodes
    right = (iterate.contact.node_force_n - iterate.elastic.gradient)[:free].ravel()
    cautious = problem.stiffness / 4
    curvature_limit = np.inf if iterate.residual < options.update_residual else cautious
    shift = iterate.shift / 4 if iterate.shift > options.first_shift / 4 else 0.0
    while shift < options.last_shift:
        values = problem.elasticity.hessian(
            iterate.positions, iterate.pressure, iterate.elastic.volume_gradient, problem.pattern, shift=shift
        )
        add_contact_stiffness(
            values, problem.face, iterate.contact, indenter, problem.pattern,
            penalty=problem.penalty, curvature_limit=curvature_limit,
        )  # fmt: skip
        if problem.solver.factorise(values):
            direction = np.zeros_like(iterate.positions)
            direction[:free] = problem.solver.solve(right).reshape(-1, 3)
            return (direction if np.isfinite(direction).all() else None), shift
        if curvature_limit > cautious:
            curvature_limit = cautious
        else:
            shift = max(options.first_shift, 4 * shift)
    return None, shift


def _search(problem: Problem, indenter: Indenter, start: Iterate, direction: Array) -> Iterate:
    """The longest acceptable step along a direction."""
    lattice, options = problem.elasticity.lattice, problem.options
    dofs = (3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)
    growth = np.einsum("ci,ci->c", start.elastic.volume_gradient, direction.ravel()[dofs]) / lattice.volumes_mm3
    jacobian = start.elastic.jacobian
    target = lattice.lame_mpa * (jacobian - 1 + growth)
    bounded = np.minimum(lattice.lame_mpa, 20 * lattice.shear_modulus_mpa)

    def merit(elastic: ElasticState, contact: ContactState) -> float:
        strain = elastic.jacobian - 1
        volume = lattice.volumes_mm3 @ (target * strain + bounded / 2 * strain**2)
        return elastic.energy_mj + float(volume) + contact.energy_mj

    reference = merit(start.elastic, start.contact)
    gradient = start.elastic.gradient - start.contact.node_force_n
    multiplier_part = target + (bounded - lattice.lame_mpa) * (jacobian - 1)
    slope = float((gradient * direction).sum() + lattice.volumes_mm3 @ (multiplier_part * growth))
    noise = 1e-9 * (abs(start.contact.energy_mj) + abs(start.elastic.energy_mj))
    alpha = min(1.0, options.step_ratio * problem.smallest_edge_mm / max(1e-300, float(np.abs(direction).max())))
    floor = min(0.1, 0.3 * start.elastic.min_jacobian)
    accepted: Iterate | None = None
    for _ in range(options.max_halvings):
        positions = start.positions + alpha * direction
        elastic = problem.elasticity.evaluate(positions)
        if not elastic.min_jacobian > floor:
            alpha /= 2
            continue
        contact = evaluate_contact(problem.face, positions, indenter, start.multipliers, problem.penalty)
        accepted = Iterate(
            positions=positions,
            pressure=start.pressure + alpha * (target - start.pressure),
            multipliers=start.multipliers,
            elastic=elastic,
            contact=contact,
            residual=_relative_residual(problem, elastic, contact),
            iteration=start.iteration + 1,
            shift=start.shift,
        )
        if slope >= 0 or merit(elastic, contact) <= reference + 1e-4 * alpha * slope + noise:
            return accepted
        alpha /= 2
    return accepted or replace(start, iteration=start.iteration + 1, stuck=True)
