"""The depth at which a press reaches a force, found on the way of one press.

Forces of contacts grow about as powers of the depth (3/2 of a ball on a half space, 1 of a flat end), so the power
between the last two places tells the next one. The way is found on one coarse lattice without friction, each
equilibrium from the one before; the end by presses from rest as they are asked for, of which one or two are needed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.quality import SOLVE_QUALITIES, SolveQuality
from magicsim.deform.solve.path import MAX_ITERATIONS, ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.limits import WHOLE, CoreFailure

FORCE_SHARE, WAY_SHARE = 0.05, 0.2
"""Largest relative error of a force that was asked for: at the end of the press, and on the way."""
FIRST_MM = 0.1
"""First depth that is tried [mm]."""
FARTHEST = 3.0
"""Largest step, in units of the depth before it."""
BALL, LEAST, MOST = 1.5, 0.5, 4.0
"""Power of the depth to begin with, and the bounds of those found."""
PATIENT, MOST_SOLVES = 6, 12
"""Places after which the interval is halved instead, and after which the search ends."""
DIGITS = 9
"""Decimals of depths, as scenes have them [mm]."""
WAY = replace(
    SOLVE_QUALITIES["control"], lattice={**SOLVE_QUALITIES["control"].lattice, "cells_across": 0, "edge_nodes": 0}
)
"""How equilibria on the way are solved."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached:
    """Where a press ends."""

    depth_mm: float
    force_n: float
    """Normal force there [N]: what was asked for, or less at the deepest place that is allowed."""
    is_met: bool
    """Whether it is the force that was asked for."""
    power: float
    """Power of the depth that the force has grown by."""
    solves: int
    """Equilibria that were solved."""
    state: Deformation | None = None
    """The equilibrium at that depth, where it is the last that was solved."""


def find_depth(
    force_at: Callable[[float], float], force_n: float, *, deepest_mm: float, first_mm: float = FIRST_MM,
    power: float = BALL, error: float = FORCE_SHARE,
) -> Reached:  # fmt: skip
    """Depth at which a growing normal force has a value [N] within a relative error, or the deepest that is allowed.

    It begins at the first depth and expects the force to grow by a power of it.
    """
    depth = round(min(first_mm, deepest_mm), DIGITS)
    low, high, last = (0.0, 0.0), (math.inf, math.inf), (0.0, 0.0)
    for solves in range(1, MOST_SOLVES + 1):
        force = force_at(depth)
        is_met = abs(force - force_n) <= error * force_n
        if is_met or (force < force_n and depth >= deepest_mm):
            return Reached(depth_mm=depth, force_n=force, is_met=is_met, power=power, solves=solves)
        low, high = ((depth, force), high) if force < force_n else (low, (depth, force))
        if last[1] > 0 and force > 0 and last[0] != depth:
            power = min(MOST, max(LEAST, math.log(force / last[1]) / math.log(depth / last[0])))
        last = (depth, force)
        guess = depth * (force_n / force) ** (1 / power) if force > 0 else math.inf
        guess = min(guess, FARTHEST * depth, deepest_mm)
        is_between = low[0] < guess < high[0] and solves < PATIENT
        depth = round(guess if is_between or not math.isfinite(high[0]) else (low[0] + high[0]) / 2, DIGITS)
    return Reached(depth_mm=low[0], force_n=low[1], is_met=False, power=power, solves=MOST_SOLVES)


def press_to_force(
    design: ElastomerDesign,
    placed: Callable[[float], Sequence[Indenter]],
    force_n: float,
    *,
    deepest_mm: float,
    friction: float = 0.0,
    quality: str = "full",
    failure: CoreFailure = WHOLE,
    max_iterations: int = MAX_ITERATIONS,
) -> Reached:
    """Presses an object into a block, quasi-static, until a normal force acts [N] or the deepest place is reached [mm].

    The object is placed at a depth [mm], and then wherever else it touches on its path: the lattice is fine at all of
    these places. A quality is a name of `SOLVE_QUALITIES`; iterations are those of one equilibrium, at most.

    Raises:
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found.
    """
    solve = SOLVE_QUALITIES[quality]

    def solver(
        solve: SolveQuality, places: Sequence[Indenter], friction: float, failure: CoreFailure = WHOLE
    ) -> ContactSolver:  # fmt: skip
        lattice = weakened(build_lattice(solve.of(design), zone=contact_zone(places, design)), failure)
        return ContactSolver(
            lattice, friction=friction, point_spacing_mm=point_spacing_mm(places[0].shape), options=solve.newton,
            max_iterations=max_iterations, core=CoreLaw.of(design, lattice, failure),
        )  # fmt: skip

    on_way, before = solver(WAY, placed(deepest_mm)[:1], 0.0), None

    def passed_n(depth_mm: float) -> float:
        nonlocal before
        before = on_way.solve(placed(depth_mm)[0], before)
        return float(before.force_n[2])

    found = find_depth(passed_n, force_n, deepest_mm=deepest_mm, error=WAY_SHARE)
    begin = deepest_mm
    if found.force_n > 0:
        begin = min(found.depth_mm * (force_n / found.force_n) ** (1 / found.power), deepest_mm)
    last: dict[float, Deformation] = {}

    def pressed_n(depth_mm: float) -> float:
        places = placed(depth_mm)
        state = solver(solve, places, friction, failure).solve(places[0])
        last.clear()
        last[depth_mm] = state
        return float(state.force_n[2])

    end = find_depth(pressed_n, force_n, deepest_mm=deepest_mm, first_mm=begin, power=found.power)
    return replace(end, solves=found.solves + end.solves, state=last.get(end.depth_mm))
