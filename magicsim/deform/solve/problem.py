"""What a Newton iteration solves, and when it stops: nothing here changes along a path."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.contact.friction import ContactLaw
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.pattern import BlockPattern
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import TableMemory
from magicsim.deform.solve.factorise import SymmetricSolver

ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Relative error of a cell's forces before they cancel."""
CAREFUL_ITERATIONS, PATIENT_ITERATIONS = 2, 3
"""Iterations of a step that has failed once, and more than once, in units of `NewtonOptions.max_iterations`."""
MOST_CONTRAST = 3e3
"""Largest over smallest modulus up to which factors are of single precision."""
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
    """Residual below which the multipliers of contact are updated, and the object's curvature counts in full."""
    multiplier_updates: int = 8
    """Updates after which the penalty is raised instead: where more points are in contact than the lattice can follow,
    multipliers need not settle."""
    penalty_growth: float = 4.0
    """Factor of the penalty then."""
    limit_residual: tuple[float, float] = (0.3, 1e-2)
    """Residuals below which the limits of friction are updated, at first and after `patience` iterations; far from
    balance the pressures mean nothing."""
    patience: int = 12
    """Iterations after which limits are updated in balance only and with relaxation."""
    penalty_ratio: float = 100.0
    """First contact penalty in units of `Problem.stiffness`."""
    slip_penalty_ratio: float = 100.0
    """Stiffness of a sticking point in the same units."""
    elastic_slip_ratio: float = 2e-4
    """Least elastic slip at the limit of friction in units of the smallest cell edge."""
    slip_mismatch: float = 1e-3
    """Largest departure from the law of friction, see `contact.augmented.slip_mismatch`."""
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
    keeps_factors: bool = True
    """Whether a factor serves as long as it does well; otherwise every iteration has its own."""
    is_condensed: bool = True
    """Whether contact is solved on the face for every step of the body, see `condensed`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A lattice, its contact face and its solver."""

    elasticity: Elasticity
    face: ContactFace
    pattern: BlockPattern
    """Pattern of the matrix with contact."""
    body_pattern: BlockPattern
    """Pattern of the body's own matrix: sparser, since contact couples nodes of a face that share no cell."""
    solver: SymmetricSolver
    options: NewtonOptions
    law: ContactLaw
    stiffness: float
    """Instantaneous Young's modulus of the skin (nu = 1/2) over the smallest cell edge [N/mm3]."""
    least_force_n: float
    """Contact forces below this do not sharpen the residual: they are small for the lattice, or its own rounding would
    exceed the tolerance [N]."""

    @classmethod
    def of(
        cls,
        elasticity: Elasticity,
        face: ContactFace,
        pattern: BlockPattern,
        body_pattern: BlockPattern,
        solver: SymmetricSolver,
        options: NewtonOptions,
        *,
        friction: float,
        shear_modulus_mpa: Array,
    ) -> Self:
        """A problem with the penalties that fit its lattice.

        Args:
            elasticity: Energy of the lattice.
            face: Where contact is tested.
            pattern: Of the matrix with contact.
            body_pattern: Of the matrix without it.
            solver: For the former.
            options: Tolerances and limits.
            friction: Coulomb's coefficient.
            shear_modulus_mpa: Instantaneous shear modulus of each cell, shape (cells,) [MPa].
        """
        lattice = elasticity.lattice
        stiffness = 3 * float(shear_modulus_mpa[: len(face.patches)].max()) / _smallest_edge_mm(lattice)
        floor = FORCE_FLOOR * float(lattice.shear_modulus_mpa.max()) * _smallest_edge_mm(lattice) ** 2
        return cls(
            elasticity=elasticity,
            face=face,
            pattern=pattern,
            body_pattern=body_pattern,
            solver=solver,
            options=options,
            law=ContactLaw(
                slip_penalty=options.slip_penalty_ratio * stiffness,
                elastic_slip_mm=options.elastic_slip_ratio * _smallest_edge_mm(lattice),
                friction=friction,
            ),
            stiffness=stiffness,
            least_force_n=max(floor, _rounding_n(lattice, shear_modulus_mpa) / options.residual),
        )

    def careful(self) -> Self:
        """This problem for a step that has failed before: friction limits wait for balance, factors are never kept."""
        iterations = CAREFUL_ITERATIONS * self.options.max_iterations
        options = replace(self.options, patience=0, max_iterations=iterations, keeps_factors=False)
        return replace(self, options=options)

    def patient(self) -> Self:
        """This problem for a step that has failed twice: plain Newton iterations, and many of them.

        Where the face snaps from one shape to another the body has to go a long way for little: steps that solve the
        contact in full go back and forth there, and plain ones follow the energy down.
        """
        iterations = PATIENT_ITERATIONS * self.options.max_iterations
        options = replace(self.options, patience=0, max_iterations=iterations, is_condensed=False)
        return replace(self, options=options)

    def on_table(self, memory: TableMemory | None) -> Self:
        """This problem with the base as an earlier load step has left it; itself where the base is bonded."""
        table = self.elasticity.table
        if table is None or memory is None:
            return self
        return replace(self, elasticity=replace(self.elasticity, table=replace(table, memory=memory)))

    def with_table_at(self, positions: Array) -> Self:
        """This problem with limits of friction below the block that belong to an equilibrium, shape (nodes, 3) [mm]."""
        table = self.elasticity.table
        return self if table is None else self.on_table(table.updated(positions))

    def free_forces(self, forces_n: Array) -> Array:
        """Forces that can move the nodes: those along held displacements are zero, shape (free nodes, 3) [N]."""
        return np.asarray(forces_n[: len(self.pattern.held) // 3] * ~self.pattern.held.reshape(-1, 3))

    @property
    def is_well_conditioned(self) -> bool:
        """Whether a factor of single precision is good enough to iterate with."""
        lattice = self.elasticity.lattice
        stiffest = max(lattice.lame_mpa.max(), lattice.coat_n_per_mm / self.smallest_edge_mm)
        return bool(stiffest < MOST_CONTRAST * lattice.shear_modulus_mpa.min())

    @property
    def smallest_edge_mm(self) -> float:
        """Shortest cell edge [mm]."""
        return _smallest_edge_mm(self.elasticity.lattice)

    @property
    def cautious(self) -> float:
        """Largest pressure times curvature of the object that counts far from balance [N/mm3]: assumed."""
        return self.stiffness / 4

    @property
    def first_penalty(self) -> float:
        """Stiffness of contact along the normal that a load step begins with [N/mm3]."""
        return self.options.penalty_ratio * self.stiffness


def _smallest_edge_mm(lattice: Lattice) -> float:
    return float(lattice.sizes_mm.min())


def _rounding_n(lattice: Lattice, shear_modulus_mpa: Array) -> float:
    """Rounding of the out-of-balance forces [N].

    Spring forces cancel those of the logarithm, and the rounding of a volume is multiplied by lambda.
    """
    areas = np.sort(lattice.sizes_mm, axis=1)[:, 1:].prod(1)
    return ROUNDING * float(np.sqrt(np.sum(((lattice.lame_mpa + shear_modulus_mpa) * areas) ** 2)))
