"""The state of a Newton iteration."""

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
    return Iterate(
        positions=positions,
        pressure=pressure,
        memory=memory,
        elastic=elastic,
        contact=contact,
        residual=_relative_residual(problem, elastic, contact),
        mismatch=slip_mismatch(problem.face, contact, memory, problem.law),
    )


def _relative_residual(problem: Problem, elastic: ElasticState, contact: ContactState) -> float:
    residual = problem.free_forces(elastic.gradient - contact.node_force_n)
    size = float(np.linalg.norm(contact.node_force_n))
    return float(np.linalg.norm(residual)) / max(problem.least_force_n, size)
