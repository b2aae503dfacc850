"""How finely equilibria are solved: in full, or as a control loop or a large dataset can wait for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from magicsim.geometry.design import ElastomerDesign

MAX_BALANCE, BALANCE_SHARE = 1e-6, 100.0
"""Largest relative difference between contact force and reaction that is accepted, and that in units of the residual
that ends the iterations, where this is more: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewtonOptions:
    """When to stop, and how far one step may go; values without a source are assumed."""

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
    reprieve: int = 0
    """Updates that a raised penalty is given before it is raised again."""
    harmless_misfit_mm: float = 0.0
    """Penetration, or gap under pressure, up to which the penalty is never raised [mm]."""
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

    @property
    def largest_balance(self) -> float:
        """Largest relative difference between contact force and reaction that is accepted."""
        return max(MAX_BALANCE, BALANCE_SHARE * self.residual)


@dataclass(frozen=True, slots=True, kw_only=True)
class SolveQuality:
    """Lattice and solver of one quality."""

    lattice: Mapping[str, Any] = field(default_factory=dict)
    """Options of a design's lattice that it replaces."""
    newton: NewtonOptions = field(default_factory=NewtonOptions)
    """When a load step is good enough: what is left of its residual is corrected by the next one."""

    def of(self, design: ElastomerDesign) -> ElastomerDesign:
        """The design as its lattice is made."""
        return design.model_copy(update={"lattice": design.lattice.model_copy(update=dict(self.lattice))})


SOLVE_QUALITIES = {
    "full": SolveQuality(),
    "control": SolveQuality(
        lattice={"growth": 3.0, "margin": 0.5, "fine_depth": 0.3, "cells_across_round": 0},
        newton=NewtonOptions(residual=1e-2, tolerance_mm=0.02, slip_mismatch=0.1),
    ),
}
"""By the names that `contact.quality` has. Control has a lattice of fewer nodes, and load steps that end at a
hundredth of the forces out of balance, after about half the Newton steps; the next step begins where the last one
ended and corrects what is left. `benchmarks/control_loop.py` measures what that costs in accuracy."""
