"""One load step: primal-dual Newton iterations for a fixed pose of the object.

The volumetric stress of each cell is an independent unknown, condensed out: the matrix keeps its size, the right-
hand side is that of the displacement problem, and the stress follows its own linearised law. Iteration counts then
do not grow as nu approaches 1/2. The contact multipliers are updated along the way as soon as the residual is
small, so an augmented Lagrangian update costs an iteration and not a solve; the limits of friction likewise.

Safeguard: a step is shortened until every Gauss point keeps a positive Jacobian and until the energy with the new
stresses as multipliers (its volume term bounded, so that stiffness in volume does not throttle the step) has
decreased.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.deform.contact import (
    ContactLaw,
    ContactMemory,
    ContactState,
    Surface,
    add_contact_stiffness,
    evaluate_contact,
    slip_mismatch,
)
from magicsim.deform.energy import Elasticity, ElasticState
from magicsim.deform.face import ContactFace
from magicsim.deform.linear import SymmetricSolver
from magicsim.deform.pattern import BlockPattern

Array = npt.NDArray[np.float64]


ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Relative error of a cell's forces before they cancel."""
FORCE_FLOOR = 1e-2
"""Contact forces below this, in units of shear modulus times smallest edge squared, do not sharpen the residual."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewtonOptions:
    """When to stop, and how far one step may go."""

    tolerance_mm: float = 0.002
    """Largest penetration, and largest gap under pressure, that are accepted."""
    residual: float = 1e-8
    """Largest norm of the out-of-balance nodal forces over that of the contact forces."""
    update_residual: float = 0.1
    """Residual below which contact multipliers are updated."""
    limit_residual: tuple[float, float] = (0.3, 1e-2)
    """Residuals below which the limits of friction are updated, at first and later; far from balance the pressures mean
    nothing."""
    patience: int = 12
    """Iterations after which limits are updated in balance only and by half, should they chase the pressures."""
    penalty_ratio: float = 100.0
    """Contact penalty in units of `Problem.stiffness`."""
    slip_penalty_ratio: float = 100.0
    """Stiffness of a sticking point in the same units."""
    slip_mismatch: float = 1e-3
    """Largest difference between friction limits and mu times the pressure, over the contact force."""
    step_ratio: float = 0.7
    """Longest step of a node in units of the smallest cell edge."""
    first_shift: float = 0.25
    """Multiple of the spring Laplacian added to a matrix that is not positive definite; four times more each try."""
    last_shift: float = 1e4
    """Multiple at which to give up."""
    max_iterations: int = 50
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
    friction: float = 0.0
    """Coulomb's coefficient."""
    shear_modulus_mpa: Array
    """Instantaneous shear modulus of each cell, shape (cells,) [MPa]; the penalties follow it."""

    @property
    def smallest_edge_mm(self) -> float:
        """Shortest cell edge [mm]."""
        return float(self.elasticity.lattice.sizes_mm.min())

    @property
    def stiffness(self) -> float:
        """Instantaneous Young's modulus of the skin (nu = 1/2) over the smallest cell edge [N/mm3]."""
        skin = self.shear_modulus_mpa[: len(self.face.patches)].max()
        return float(3 * skin / self.smallest_edge_mm)

    @property
    def rounding_n(self) -> float:
        """Contact force below which the residual's own rounding would exceed its tolerance [N].

        Spring forces cancel those of the logarithm, and the rounding of a volume is multiplied by lambda.
        """
        lattice = self.elasticity.lattice
        areas = np.sort(lattice.sizes_mm, axis=1)[:, 1:].prod(1)
        moduli = lattice.lame_mpa + self.shear_modulus_mpa
        return ROUNDING * float(np.sqrt(np.sum((moduli * areas) ** 2))) / self.options.residual

    @property
    def law(self) -> ContactLaw:
        """Penalties and friction."""
        return ContactLaw(
            penalty=self.options.penalty_ratio * self.stiffness,
            slip_penalty=self.options.slip_penalty_ratio * self.stiffness,
            friction=self.friction,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class IterationFigures:
    """What one iteration ended with."""

    residual: float
    """Relative norm of the out-of-balance forces."""
    max_penetration_mm: float
    """Deepest contact point inside the object [mm]."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    shift: float
    """Multiple of the spring Laplacian that made the matrix positive definite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Iterate:
    """State of the Newton iteration, with everything that depends on it already evaluated."""

    positions: Array
    pressure: Array
    memory: ContactMemory
    elastic: ElasticState
    contact: ContactState
    residual: float
    """Relative norm of the out-of-balance forces."""
    mismatch: float
    """Of the friction limits, see `slip_mismatch`."""
    iteration: int
    shift: float
    """Spring Laplacian that the last matrix needed."""
    stuck: bool = False
    """Whether no acceptable step was found."""

    def figures(self) -> IterationFigures:
        """The numbers to keep of it."""
        return IterationFigures(
            residual=self.residual,
            max_penetration_mm=self.contact.max_penetration_mm,
            min_jacobian=self.elastic.min_jacobian,
            shift=self.shift,
        )


def init(problem: Problem, surface: Surface, positions: Array, pressure: Array, memory: ContactMemory) -> Iterate:
    """Evaluates the starting point.

    Args:
        problem: The lattice and its solver.
        surface: The object in the pose of this load step.
        positions: Node positions, shape (nodes, 3) [mm].
        pressure: Volumetric stress, shape (cells,) [MPa].
        memory: Multipliers, anchors and friction limits.
    """
    elastic = problem.elasticity.evaluate(positions)
    contact = evaluate_contact(problem.face, positions, surface, memory, problem.law)
    return Iterate(
        positions=positions,
        pressure=pressure,
        memory=memory,
        elastic=elastic,
        contact=contact,
        residual=_relative_residual(problem, elastic, contact),
        mismatch=slip_mismatch(problem.face, contact, memory, problem.law),
        iteration=0,
        shift=0.0,
    )


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
    memory = _updated_memory(problem, iterate)
    if memory is not iterate.memory:
        contact = evaluate_contact(problem.face, iterate.positions, surface, memory, problem.law)
        iterate = replace(iterate, memory=memory, contact=contact)
    direction, shift = _direction(problem, surface, iterate)
    if direction is None:
        return replace(iterate, stuck=True, iteration=iterate.iteration + 1)
    return _search(problem, surface, replace(iterate, shift=shift), direction)


def _updated_memory(problem: Problem, iterate: Iterate) -> ContactMemory:
    options, memory, contact = problem.options, iterate.memory, iterate.contact
    if problem.friction > 0:
        memory = replace(memory, normal=contact.normal)
    patient = iterate.iteration >= options.patience
    if iterate.mismatch > options.slip_mismatch and iterate.residual < options.limit_residual[patient]:
        wanted = problem.friction * contact.pressure_mpa
        memory = replace(memory, limit_mpa=(wanted + memory.limit_mpa) / 2 if patient else wanted)
    if iterate.residual < options.update_residual and contact.misfit_mm > 0.9 * options.tolerance_mm:
        memory = replace(memory, multipliers_mpa=contact.pressure_mpa)
    return memory


def _relative_residual(problem: Problem, elastic: ElasticState, contact: ContactState) -> float:
    lattice = problem.elasticity.lattice
    residual = (elastic.gradient - contact.node_force_n)[: lattice.free_nodes]
    floor = FORCE_FLOOR * float(lattice.shear_modulus_mpa.max()) * problem.smallest_edge_mm**2
    return float(np.linalg.norm(residual) / max(floor, problem.rounding_n, float(np.linalg.norm(contact.node_force_n))))


def _direction(problem: Problem, surface: Surface, iterate: Iterate) -> tuple[Array | None, float]:
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
            values, problem.face, iterate.contact, surface, iterate.memory, problem.law, problem.pattern,
            curvature_limit=curvature_limit,
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


def _search(problem: Problem, surface: Surface, start: Iterate, direction: Array) -> Iterate:
    """The longest acceptable step along a direction."""
    lattice, options, volumes = problem.elasticity.lattice, problem.options, problem.elasticity.volumes
    dofs = (3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)
    growth = np.einsum("ci,ci->c", start.elastic.volume_gradient, direction.ravel()[dofs]) / volumes
    jacobian = start.elastic.jacobian
    target = lattice.lame_mpa * (jacobian - 1 + growth)
    bounded = np.minimum(lattice.lame_mpa, 20 * lattice.shear_modulus_mpa)

    def merit(elastic: ElasticState, contact: ContactState) -> float:
        strain = elastic.jacobian - 1
        volume = volumes @ (target * strain + bounded / 2 * strain**2)
        return elastic.energy_mj + float(volume) + contact.energy_mj

    reference = merit(start.elastic, start.contact)
    gradient = start.elastic.gradient - start.contact.node_force_n
    multiplier_part = target + (bounded - lattice.lame_mpa) * (jacobian - 1)
    slope = float((gradient * direction).sum() + volumes @ (multiplier_part * growth))
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
        contact = evaluate_contact(problem.face, positions, surface, start.memory, problem.law)
        accepted = Iterate(
            positions=positions,
            pressure=start.pressure + alpha * (target - start.pressure),
            memory=start.memory,
            elastic=elastic,
            contact=contact,
            residual=_relative_residual(problem, elastic, contact),
            mismatch=slip_mismatch(problem.face, contact, start.memory, problem.law),
            iteration=start.iteration + 1,
            shift=start.shift,
        )
        if slope >= 0 or merit(elastic, contact) <= reference + 1e-4 * alpha * slope + noise:
            return accepted
        alpha /= 2
    return accepted or replace(start, iteration=start.iteration + 1, stuck=True)
