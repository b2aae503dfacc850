"""The depth at which a press reaches a force, found on the way of one press.

Each equilibrium starts from the one before. Forces of contacts grow about as powers of the depth (3/2 of a ball on a
half space, 1 of a flat end), so the power between the last two places tells the next one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import MAX_ITERATIONS, ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.rigid_object import ObjectBase

FORCE_SHARE, WAY_SHARE = 0.03, 0.2
"""Largest relative error of a force that was asked for: at the end of the press, and on the way."""
FIRST_MM = 0.1
"""First depth that is tried [mm]."""
FARTHEST = 3.0
"""Largest step, in units of the depth before it."""
BALL, LEAST, MOST = 1.5, 0.5, 4.0
"""Power of the depth to begin with, and the bounds of those found."""
PATIENT, MOST_SOLVES = 6, 12
"""Places after which the interval is halved instead, and after which the search ends."""
HASTY = 20
"""Iterations after which a press from the place before is begun again from rest: ordinary ones take 4 to 15."""
SAME = 0.05
"""Relative change of a depth up to which it has the same lattice."""


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


def find_depth(
    force_at: Callable[[float], float], force_n: float, *, deepest_mm: float, first_mm: float = FIRST_MM,
    power: float = BALL, error: float = FORCE_SHARE,
) -> Reached:  # fmt: skip
    """Depth at which a growing force has a value.

    Args:
        force_at: Normal force at a depth [N].
        force_n: The force to find [N].
        deepest_mm: Largest depth that is allowed [mm].
        first_mm: Where to begin [mm].
        power: Of the depth, by which the force is expected to grow.
        error: Largest relative error of the force.
    """
    depth = min(first_mm, deepest_mm)
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
        depth = guess if is_between or not math.isfinite(high[0]) else (low[0] + high[0]) / 2
    return Reached(depth_mm=low[0], force_n=low[1], is_met=False, power=power, solves=MOST_SOLVES)


def press_to_force(
    design: ElastomerDesign,
    object_config: ObjectBase,
    force_n: float,
    *,
    deepest_mm: float,
    x_mm: float = 0.0,
    y_mm: float = 0.0,
    friction: float = 0.0,
    max_iterations: int = MAX_ITERATIONS,
) -> Reached:
    """Presses an object into a block until a normal force acts, quasi-static.

    What the lattice resolves depends on the depth: the press begins on the design's own spacing, and ends on the
    lattice that a press to that depth has by itself, within a few hundredths of the depth.

    Args:
        design: The block.
        object_config: The object.
        force_n: Normal force at which the press ends [N].
        deepest_mm: Depth at which it ends in any case [mm].
        x_mm: The object's origin along x [mm].
        y_mm: Along y [mm].
        friction: Coulomb's coefficient.
        max_iterations: Iterations of one equilibrium before the press is given up.

    Raises:
        GeometryError: The design cannot be built.
        ConvergenceError: No valid equilibrium was found.
    """
    path = _Path(
        design=design, friction=friction, max_iterations=max_iterations,
        placed=lambda depth: place_object(object_config, gap_mm=-depth, x_mm=x_mm, y_mm=y_mm, design=design),
    )  # fmt: skip
    plain = design.lattice.model_copy(update={"cells_across": 0, "edge_nodes": 0})
    rough = replace(path, design=design.model_copy(update={"lattice": plain}), lasts=math.inf, made_for_mm=deepest_mm, friction=0.0)
    way = find_depth(rough.force_n, force_n, deepest_mm=deepest_mm, error=WAY_SHARE)
    begin = deepest_mm
    if way.force_n > 0:
        begin = min(way.depth_mm * (force_n / way.force_n) ** (1 / way.power), deepest_mm)
    end = find_depth(path.force_n, force_n, deepest_mm=deepest_mm, first_mm=begin, power=way.power)
    return replace(end, solves=way.solves + end.solves)


@dataclass(slots=True, kw_only=True)
class _Path:
    """One press that goes deeper, and the lattice that carries it."""

    design: ElastomerDesign
    friction: float
    max_iterations: int
    placed: Callable[[float], Indenter]
    """The object at a depth [mm]."""
    lasts: float = SAME
    """Largest relative change of the depth before the lattice is made anew."""
    made_for_mm: float = 0.0
    """Depth that the lattice is fine for; 0 where it is the next one's [mm]."""
    solver: ContactSolver | None = None
    state: Deformation | None = None

    def force_n(self, depth_mm: float) -> float:
        """Normal force at a depth, from the place before [N]."""
        if self.solver is None or abs(depth_mm / self.made_for_mm - 1) > self.lasts:
            if self.solver is not None or not self.made_for_mm:
                self.made_for_mm = depth_mm
            pose = self.placed(self.made_for_mm)
            self.solver, self.state = ContactSolver(
                build_lattice(self.design, zone=contact_zone([pose], self.design)), friction=self.friction,
                point_spacing_mm=point_spacing_mm(pose.shape), max_iterations=self.max_iterations,
            ), None  # fmt: skip
        pose = self.placed(depth_mm)
        try:
            self.state = self.solver.solve(pose, self.state, most=HASTY if self.state is not None else None)
        except ConvergenceError:
            if self.state is None:
                raise
            self.state = self.solver.solve(pose)  # a wide contact with friction may be nearer from rest
        return float(self.state.force_n[2])
