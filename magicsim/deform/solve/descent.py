"""Parts of a Newton iteration: a matrix that is definite, and how far to go along the direction that it gives.

A step is shortened until every Gauss point keeps a positive Jacobian and until the energy with the new stresses as
multipliers (its volume term bounded, so that stiffness in volume does not throttle the step) has decreased. A step
from a matrix stiffer than the Hessian is doubled while the energy still decreases: away from a saddle, as where a
point is about to slide over an edge, such steps are short by a large and almost constant factor.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.augmented import Surface
from magicsim.deform.solve.iterate import Iterate, evaluated
from magicsim.deform.solve.problem import Problem

T = TypeVar("T")
ARMIJO = 1e-4
"""Least decrease in units of the one that the slope promises (Nocedal and Wright 2006, 3.1)."""
BOUND = 20.0
"""Largest bulk stiffness that a step has to respect, in units of the shear modulus: assumed."""
NOISE = 1e-9
"""Relative rounding of the energy: assumed."""
NEAR, CONTRACTED = 0.3, 0.5
"""Residual from which a full step will do that leaves no more than the second part of it. There the energy is a poor
judge: the volumetric stresses, its multipliers, lag behind by one step, and it refused steps that took two digits off
the residual."""
FLOOR, FLOOR_SHARE = 0.1, 0.3
"""Least Jacobian that a step may leave, or this part of the present one where that is less: assumed."""


def stiffenings(
    *, first: float, growth: float, last: float, cautious: float, is_near: bool, shift: float = 0.0
) -> Iterator[tuple[float, float]]:
    """Bounds of pressure times curvature [N/mm3] and multiples of a definite matrix, to try until a matrix is definite.

    No bound where equilibrium is near, then the cautious one; multiples from `shift` on, and from `first` to `last`,
    each so many times the one before.
    """
    if is_near:
        yield np.inf, shift
    while shift <= last:
        yield cautious, shift
        shift = max(first, growth * shift)


def decreases(value: float, reference: float, promised: float, noise: float) -> bool:
    """Whether an energy [mJ] has decreased by enough of what the slope promises (a negative change), but for noise."""
    return value <= reference + ARMIJO * promised + noise


def shortened(
    accepts: Callable[[Any, float], bool], trial: Callable[[float], T | None], *, longest: float, halvings: int
) -> tuple[T | None, float, bool]:
    """The longest acceptable step among halved ones: its end, its part, and whether that was accepted.

    A trial is what a part of the step leads to, None where that is nowhere. Where none is acceptable, the last one that
    led somewhere.
    """
    alpha, best, part = longest, None, 0.0
    for _ in range(halvings):
        end = trial(alpha)
        if end is not None:
            best, part = end, alpha
            if accepts(end, alpha):
                return best, part, True
        alpha /= 2
    return best, part, False


def search(problem: Problem, surface: Surface, start: Iterate, direction: Array, *, is_stiffened: bool) -> Iterate:
    """The state after the longest acceptable step along a direction; stuck where every trial folds a cell."""
    options, lattice, volumes = problem.options, problem.elasticity.lattice, problem.elasticity.volumes
    growth = np.einsum("ci,ci->c", start.elastic.volume_gradient, direction[lattice.cells].reshape(-1, 24)) / volumes
    strain = start.elastic.jacobian - 1
    # the new volumetric stresses are the multipliers of the merit, and the bulk stiffness that counts is bounded
    target = lattice.lame_mpa * (strain + growth)
    bounded = np.minimum(lattice.lame_mpa, BOUND * lattice.shear_modulus_mpa)
    stress = target + (bounded - lattice.lame_mpa) * strain
    gradient = start.elastic.gradient - start.contact.node_force_n
    slope = float((gradient * direction).sum() + volumes @ (stress * growth))
    noise = NOISE * (abs(start.contact.energy_mj) + abs(start.elastic.energy_mj))
    longest = options.step_ratio * lattice.smallest_edge_mm / max(1e-300, float(np.abs(direction).max()))
    floor = min(FLOOR, FLOOR_SHARE * start.elastic.min_jacobian)

    def merit(iterate: Iterate) -> float:
        strain = iterate.elastic.jacobian - 1
        volume = volumes @ (target * strain + bounded / 2 * strain**2)
        return iterate.elastic.energy_mj + float(volume) + iterate.contact.energy_mj

    def trial(alpha: float) -> Iterate | None:
        pressure = start.pressure + min(1.0, alpha) * (target - start.pressure)
        positions = start.positions + alpha * direction
        end = evaluated(problem, surface, positions, pressure, start.memory)
        return replace(end, taken=alpha, rungs=start.rungs) if end.elastic.min_jacobian > floor else None

    reference = merit(start)

    def accepts(end: Iterate, alpha: float) -> bool:
        is_newton = start.residual < NEAR and not is_stiffened and alpha == 1
        if (is_newton and end.residual < CONTRACTED * start.residual) or slope >= 0:
            return True  # a direction that promises no decrease is taken as it is
        return decreases(merit(end), reference, alpha * slope, noise)

    best, _, _ = shortened(accepts, trial, longest=min(1.0, longest), halvings=options.max_halvings)
    return best if best is not None else replace(start, stuck=True)
