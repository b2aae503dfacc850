"""The state of a Newton iteration, what the search for an equilibrium has cost, and what is said if there is none."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import ContactState, Surface, evaluate_contact, slip_mismatch
from magicsim.deform.contact.friction import ContactMemory
from magicsim.deform.lattice.energy import ElasticState
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import Problem


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
    """Mismatch of the friction limits, see `slip_mismatch`."""
    iteration: int = 0
    shift: float = 0.0
    """Spring Laplacian that the last matrix needed."""
    taken: float = 1.0
    """Part of the last step's direction that was taken."""
    rungs: frozenset[Rung] = frozenset()
    """Rungs of the ladder, on which this load step stands so far."""
    stuck: bool = False
    """Whether no acceptable step was found."""

    def on(self, *rungs: Rung) -> Self:
        """The state with rungs added."""
        return replace(self, rungs=self.rungs.union(rungs))

    @property
    def shortened(self) -> bool:
        """Whether the last step was shorter than Newton's."""
        return self.taken < 1


def evaluated(problem: Problem, surface: Surface, positions: Array, pressure: Array, memory: ContactMemory) -> Iterate:
    """A state with node positions, shape (nodes, 3) [mm], and volumetric stresses, shape (cells,) [MPa], evaluated."""
    elastic = problem.elasticity.evaluate(positions)
    contact = evaluate_contact(problem.face, positions, surface, memory, problem.law)
    left = problem.free_forces(elastic.gradient - contact.node_force_n)
    size = max(problem.least_force_n, float(np.linalg.norm(contact.node_force_n)))
    return Iterate(
        positions=positions,
        pressure=pressure,
        memory=memory,
        elastic=elastic,
        contact=contact,
        residual=float(np.linalg.norm(left)) / size,
        mismatch=slip_mismatch(problem.face, contact, memory, problem.law),
    )


LEAST_LIFT = 0.01
"""Pressures that push back, in units of their sum over all points of the face, below which the object has pierced it:
what is left squeezes its flanks; assumed."""
LOGGER = logging.getLogger(__name__)
PARTS = 1000
"""In which progress is told."""
Progress = Callable[[int, int, str], None]
"""Told the done and all parts of the way, the first of them from the start, and what it has cost."""


@dataclass(slots=True)
class Effort:
    """Cost of a solve so far."""

    most: int
    """Iterations after which no further load step is begun."""
    iterations: int = 0
    shifted: int = 0
    """Iterations whose matrix was not positive definite before a multiple of the spring Laplacian was added."""
    cutbacks: int = 0
    """Load steps that were halved."""
    restarts: int = 0
    """Paths begun again from rest."""
    rungs: frozenset[Rung] = frozenset()
    """Rungs of the ladder, on which the load steps stand that were solved."""
    last: Iterate | None = None
    """Where the last load step ended."""
    share: float = 0.0
    """How much of the way is done."""
    progress: Progress | None = None

    def note(self, iterate: Iterate) -> None:
        """Counts an iteration, and tells how far the solve is, if anybody asked."""
        self.iterations, self.shifted, self.last = self.iterations + 1, self.shifted + (iterate.shift > 0), iterate
        LOGGER.debug(
            "iteration %d: residual %.3g, min J %.3g, penetration %.3g mm, shift %.3g", iterate.iteration,
            iterate.residual, iterate.elastic.min_jacobian, iterate.contact.max_penetration_mm, iterate.shift,
        )  # fmt: skip
        if self.progress is not None:
            cost = f"{self.iterations} iterations, {self.cutbacks} halved steps, {self.restarts} restarts"
            self.progress(1 + int((PARTS - 1) * self.share), PARTS, cost)


def part_of(progress: Progress, number: int, count: int) -> Progress:
    """Progress of one solve, numbered from 0, out of several as that of all of them."""
    return lambda done, parts, note: progress(number * parts + done, count * parts, note)


def force_balance(problem: Problem, iterate: Iterate) -> float:
    """|Contact force - reaction of the base| over the contact force; 0 where nothing presses."""
    applied = iterate.contact.node_force_n
    size = float(np.linalg.norm(applied.sum(0)))
    unbalanced = applied - iterate.elastic.gradient
    reaction = unbalanced.sum(0) - problem.free_forces(unbalanced).sum(0)
    if iterate.elastic.table is not None:
        reaction -= iterate.elastic.table.node_force_n.sum(0)
    return float(np.linalg.norm(applied.sum(0) - reaction)) / size if size > 0 else 0.0


def lift(problem: Problem, iterate: Iterate) -> float:
    """Pressures that push back, in units of their sum over all points of the face; 0 where nothing touches.

    Friction is left aside: a steep wedge may hold itself by it, and pull.
    """
    pressing = problem.face.area_mm2 * iterate.contact.pressure_mpa
    total = pressing.sum()
    return float(pressing @ iterate.contact.normal[:, 2] / total) if total > 0 else 0.0


def report(problem: Problem, effort: Effort) -> str:
    """One line with the figures of the last load step beside what was asked for."""
    iterate, options = effort.last, problem.options
    if iterate is None:
        return "the deformation did not start"
    return (
        f"the deformation did not reach a valid equilibrium after {effort.iterations} iterations, "
        f"{effort.cutbacks} halved steps and {effort.restarts} restarts: residual {iterate.residual:.2g} (at most "
        f"{options.residual:g}), min J {iterate.elastic.min_jacobian:.3g} (above 0), penetration "
        f"{iterate.contact.max_penetration_mm:.3g} mm (at most {options.tolerance_mm:g} mm), force balance "
        f"{force_balance(problem, iterate):.2g} (at most {options.largest_balance:g}), friction limits off by "
        f"{iterate.mismatch:.2g} (at most {options.slip_mismatch:g})"
    )


ITERATION_S, ITERATION_UNKNOWNS = 0.1, 15_000
"""Time of an iteration with a factor of its own on two cores at so many unknowns, beyond by their power of 4/3."""


def report_bound(problem: Problem, effort: Effort, bound: int, depth_mm: float, wanted_mm: float) -> str:
    """Message where the bound on iterations is reached on the way; the time is an estimate, the same everywhere."""
    unknowns = problem.pattern.size
    minutes = effort.iterations * ITERATION_S * max(1.0, unknowns / ITERATION_UNKNOWNS) ** (4 / 3) / 60
    return (
        f"the press met its bound of max_iterations = {bound} (of a scene contact.max_iterations; about {minutes:.2g} "
        f"min at {unknowns} unknowns) {depth_mm:.3g} mm deep, and {wanted_mm:.3g} mm were asked for: press less deep, "
        "mend a mesh that passes through itself, take a coarser lattice.spacing_mm, or raise the bound"
    )


def report_passage(problem: Problem, effort: Effort) -> str:
    """Message where the last load step ended with the object through the face."""
    share = 0.0 if effort.last is None else lift(problem, effort.last)
    return (
        f"the object passed through the contact face: {share:.2g} of the pressures on the face push back (above "
        f"{LEAST_LIFT:g}) after {effort.iterations} iterations, {effort.cutbacks} halved steps and "
        f"{effort.restarts} restarts; it is pressed deeper than it is high, or a soft face would close above it, or "
        "lattice.spacing_mm is too coarse for it"
    )
