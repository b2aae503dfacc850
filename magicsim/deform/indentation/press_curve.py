"""Force against depth of one contact, along one path that is solved once."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.indentation.path_force import PathForce
from magicsim.deform.indentation.press import (
    MAX_TOLERANCE_MM,
    PressResult,
    check_depth,
    check_friction,
    check_number,
    follow,
)
from magicsim.deform.solve.effort import Progress
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import ObjectBase
from magicsim.waiting import Told, on_stderr, unheard, waiting

MAX_POINTS = 1000
"""Most depths of one curve."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PressCurve:
    """What an object does to a block at every depth of one press."""

    result: PressResult
    """At the deepest place, with what the whole path has cost; its history is the curve."""

    @property
    def points(self) -> tuple[PathForce, ...]:
        """The depths in order."""
        return self.result.history

    @property
    def depths_mm(self) -> Array:
        """Depths from first contact, shape (points,) [mm]."""
        return np.array([each.depth_mm for each in self.points])

    @property
    def forces_n(self) -> Array:
        """Force of the object on the sensor at each depth, shape (points, 3) [N]."""
        return np.array([each.force_n for each in self.points])

    @property
    def areas_mm2(self) -> Array:
        """Area that touches at each depth, shape (points,) [mm2]."""
        return np.array([each.contact_area_mm2 for each in self.points])


def press_curve(
    design: ElastomerDesign,
    object_config: ObjectBase,
    depths_mm: Sequence[float] | Array,
    *,
    friction: float = 0.0,
    tolerance_mm: float = 0.002,
    progress: Progress | None = None,
    told: Told = on_stderr,
) -> PressCurve:
    """Presses an object deeper and deeper into a block; quasi-static.

    One lattice, fine where the deepest press touches, carries the whole curve, and each depth starts from the one
    before. Components that symmetry forbids are exactly zero (`magicsim.deform.indentation.symmetry`).

    Args:
        design: The block.
        object_config: The object.
        depths_mm: Depths from first contact along +z, each larger than the one before [mm].
        friction: Coulomb's coefficient between object and face.
        tolerance_mm: Largest penetration at any contact point [mm].
        progress: Told after every iteration, see `Progress`.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A number is not allowed.
        GeometryError: The design cannot be built.
        ConvergenceError: A depth has no valid equilibrium.
    """
    depths = [float(depth) for depth in depths_mm]
    if not 1 <= len(depths) <= MAX_POINTS:
        msg = f"depths_mm has {len(depths)} depths: 1 to {MAX_POINTS} are allowed"
        raise ConfigError(msg)
    for depth in depths:
        check_depth(depth, design)
    for before, after in pairwise(depths):
        if not before < after:
            msg = (
                f"depths_mm = {after:g} after {before:g} is not allowed: each depth must be larger than the one before"
            )
            raise ConfigError(msg)
    check_friction(friction)
    check_number("tolerance_mm", tolerance_mm, 1e-6, MAX_TOLERANCE_MM, "a tenth of a millimetre")
    steps = [(place_object(object_config, gap_mm=-depth), math.inf) for depth in depths]
    path = [0.0] * len(steps)
    with waiting("pressing deeper and deeper", told if progress is None else unheard) as share:
        result = follow(design, steps, path, friction=friction, tolerance_mm=tolerance_mm, progress=progress or share)
    return PressCurve(result=result)
