"""A press that takes time: rate-dependent force on the way in, relaxation at hold.

The body needs a Prony series (`materials.body.prony`). The object moves at a constant speed and then stays; time steps
are even on the way and grow geometrically at hold, where the response slows down.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from magicsim.deform.lattice.relaxation import Branches, branch_moduli
from magicsim.deform.lattice.structure import Lattice
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter

STEP_MM = 0.1
"""Motion of the object in one time step [mm]."""
HOLD_STEPS = 8
"""Time steps a decade at hold."""
FIRST_HOLD_S = 0.01
"""Length of the first time step at hold [s]."""
LEAST_POISSON = 0.45
"""Least instantaneous Poisson's ratio: below, the bulk modulus is too small for the instantaneous stiffness."""


def body_branches(design: ElastomerDesign, lattice: Lattice) -> Branches:
    """The branches of a design for a timed path.

    Raises:
        ConfigError: The body has no Prony series, or its bulk modulus is too small for it.
    """
    body = design.materials.body
    if not body.prony:
        msg = "materials.body.prony is missing: a timed path needs the relaxation of the body (time_s and modulus_mpa)"
        raise ConfigError(msg)
    bulk, shear = body.bulk_modulus_mpa, body.instantaneous_shear_modulus_mpa
    ratio = (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
    if ratio < LEAST_POISSON:
        least = 2 * shear * (1 + LEAST_POISSON) / (3 * (1 - 2 * LEAST_POISSON))
        needed = 0.5 - body.youngs_modulus_mpa / (6 * least)
        msg = (
            f"materials.body.poisson_ratio = {body.poisson_ratio:g} is not allowed on a timed path: its bulk modulus "
            f"of {bulk:.3g} MPa is too small for the instantaneous shear modulus of {shear:.3g} MPa; must be at least "
            f"{needed:.5f}"
        )
        raise ConfigError(msg)
    return branch_moduli(design, lattice, [(term.time_s, term.modulus_mpa) for term in body.prony])


def timed_poses(
    poses: list[Indenter], lengths_mm: list[float], *, speed_mm_s: float, hold_s: float
) -> Iterator[tuple[Indenter, float]]:
    """Poses along a path with the time that each step takes [s].

    Args:
        poses: First contact and the end of each straight stage.
        lengths_mm: Length of each stage [mm].
        speed_mm_s: Of the object [mm/s].
        hold_s: Time at the end of the path [s].
    """
    for (start, end), length in zip(pairwise(poses), lengths_mm, strict=True):
        steps = max(1, math.ceil(length / STEP_MM - 1e-9))
        for number in range(1, steps + 1):
            share = number / steps
            position = (1 - share) * start.pose.position_mm + share * end.pose.position_mm
            yield replace(end, pose=replace(end.pose, position_mm=position)), length / steps / speed_mm_s
    if hold_s > 0:
        first = min(FIRST_HOLD_S, hold_s)
        count = math.ceil(HOLD_STEPS * math.log10(hold_s / first)) + 1
        for before, after in pairwise([0.0, *np.geomspace(first, hold_s, count).tolist()]):
            yield poses[-1], after - before
