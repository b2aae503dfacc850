"""What a Newton iteration is made of: a matrix that is definite, and how far to go along the direction that it gives.

A step is shortened until every Gauss point keeps a positive Jacobian and until the energy with the new stresses as
multipliers (its volume term bounded, so that stiffness in volume does not throttle the step) has decreased. A step
from a matrix stiffer than the Hessian is doubled while the energy still decreases: away from a saddle, as where a
point is about to slide over an edge, such steps are short by a large and almost constant factor.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Self, TypeVar

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import Surface
from magicsim.deform.solve.iterate import Iterate, evaluated
from magicsim.deform.solve.ladder import Rung
from magicsim.deform.solve.problem import Problem

T = TypeVar("T")
ARMIJO = 1e-4
"""Least decrease in units of the one that the slope promises."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stiffening:
    """What makes a matrix definite."""

    curvature_limit: float
    """Largest pressure times curvature of the object that counts [N/mm3]."""
    shift: float
    """Multiple of a definite matrix that is added."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shifts:
    """Multiples that are tried in turn."""

    first: float
    """Least that is tried after 0."""
    growth: float
    """Each over the one before."""
    last: float
    """At which to give up."""


def stiffenings(shifts: Shifts, *, cautious: float, is_near: bool, shift: float = 0.0) -> Iterator[Stiffening]:
    """What to try in turn until a matrix is definite: nothing, then a bound of the curvature, then shifts.

    Args:
        shifts: Multiples.
        cautious: The bound [N/mm3].
        is_near: Whether equilibrium is so near that the object's curvature may count in full.
        shift: Where to begin.
    """
    if is_near:
        yield Stiffening(curvature_limit=np.inf, shift=shift)
    while shift <= shifts.last:
        yield Stiffening(curvature_limit=cautious, shift=shift)
        shift = max(shifts.first, shifts.growth * shift)


def decreases(value: float, reference: float, promised: float, noise: float) -> bool:
    """Whether an energy has decreased enough.

    Args:
        value: After the step [mJ].
        reference: Before it [mJ].
        promised: Change that the slope promises, negative [mJ].
        noise: Rounding of either [mJ].
    """
    return value <= reference + ARMIJO * promised + noise


def shortened(
    accepts: Callable[[Any, float], bool], trial: Callable[[float], T | None], *, longest: float, halvings: int
) -> tuple[T | None, float, bool]:
    """The longest acceptable step among halved ones.

    Args:
        accepts: Whether a trial will do.
        trial: What a part of the step leads to; None where that is nowhere.
        longest: Part to begin with.
        halvings: Trials.

    Returns:
        What was found, the part of the step, and whether it was accepted: the last trial that led somewhere otherwise.
    """
    alpha, best, part = longest, None, 0.0
    for _ in range(halvings):
        found = trial(alpha)
        if found is not None:
            best, part = found, alpha
            if accepts(found, alpha):
                return best, part, True
        alpha /= 2
    return best, part, False


BOUND = 20.0
"""Largest bulk stiffness that a step has to respect, in units of the shear modulus."""
NOISE = 1e-9
"""Relative rounding of the energy."""
NEAR, CONTRACTED = 0.3, 0.5
"""Residual from which a full step will do that leaves no more than the second part of it. There the energy is a poor
judge: the volumetric stresses, its multipliers, lag behind by one step, and it refused steps that took two digits off
the residual."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Direction:
    """A step to be taken in part, in full or more."""

    nodes: Array
    """Motion of the nodes, shape (nodes, 3) [mm]."""
    shift: float
    """Multiple of the spring Laplacian in its matrix."""
    is_stiffened: bool
    """Whether its matrix is stiffer than the Hessian, so that the step may be short of the minimum along it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Merit:
    """Energy along a direction, with the new volumetric stresses as multipliers."""

    volumes: Array
    target: Array
    """The new volumetric stresses, shape (cells,) [MPa]."""
    bounded: Array
    """Bulk stiffness that counts, shape (cells,) [MPa]."""
    reference: float
    slope: float
    noise: float

    @classmethod
    def of(cls, problem: Problem, start: Iterate, direction: Array) -> Self:
        lattice, volumes = problem.elasticity.lattice, problem.elasticity.volumes
        motion = direction[lattice.cells].reshape(-1, 24)
        growth = np.einsum("ci,ci->c", start.elastic.volume_gradient, motion) / volumes
        strain = start.elastic.jacobian - 1
        bounded = np.minimum(lattice.lame_mpa, BOUND * lattice.shear_modulus_mpa)
        target = lattice.lame_mpa * (strain + growth)
        gradient = start.elastic.gradient - start.contact.node_force_n
        stress = target + (bounded - lattice.lame_mpa) * strain
        merit = cls(
            volumes=volumes,
            target=target,
            bounded=bounded,
            reference=0.0,
            slope=float((gradient * direction).sum() + volumes @ (stress * growth)),
            noise=NOISE * (abs(start.contact.energy_mj) + abs(start.elastic.energy_mj)),
        )
        return replace(merit, reference=merit.value(start))

    def value(self, iterate: Iterate) -> float:
        """Energy [mJ]."""
        strain = iterate.elastic.jacobian - 1
        volume = self.volumes @ (self.target * strain + self.bounded / 2 * strain**2)
        return iterate.elastic.energy_mj + float(volume) + iterate.contact.energy_mj

    def accepts(self, iterate: Iterate, alpha: float) -> bool:
        """Whether the energy decreased enough; any step will do where the direction promises no decrease."""
        return self.slope >= 0 or decreases(self.value(iterate), self.reference, alpha * self.slope, self.noise)


def search(problem: Problem, surface: Surface, start: Iterate, direction: Direction) -> Iterate:
    """The state after the longest acceptable step; stuck where every trial folds a cell.

    Args:
        problem: The lattice and its solver.
        surface: The object in the pose of this load step.
        start: Where the step begins.
        direction: Where it goes.
    """
    options, merit = problem.options, _Merit.of(problem, start, direction.nodes)
    longest = options.step_ratio * problem.smallest_edge_mm / max(1e-300, float(np.abs(direction.nodes).max()))
    floor = min(0.1, 0.3 * start.elastic.min_jacobian)

    def trial(alpha: float) -> Iterate | None:
        pressure = start.pressure + min(1.0, alpha) * (merit.target - start.pressure)
        positions = start.positions + alpha * direction.nodes
        found = evaluated(problem, surface, positions, pressure, start.memory)
        return replace(found, taken=alpha, rungs=start.rungs) if found.elastic.min_jacobian > floor else None

    def accepts(found: Iterate, alpha: float) -> bool:
        is_newton = start.residual < NEAR and not direction.is_stiffened and alpha == 1
        return (is_newton and found.residual < CONTRACTED * start.residual) or merit.accepts(found, alpha)

    best, alpha, is_accepted = shortened(accepts, trial, longest=min(1.0, longest), halvings=options.max_halvings)
    if best is None:
        return replace(start, stuck=True)
    if not (is_accepted and direction.is_stiffened) or alpha < 1 or merit.slope >= 0:
        return best
    while 2 * alpha <= longest:
        alpha *= 2
        found = trial(alpha)
        if found is None or merit.value(found) >= merit.value(best):
            break
        best = found.on(Rung.STRETCHED)
    return best
