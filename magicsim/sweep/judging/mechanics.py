"""How hard a design is: force and stiffness of the press that is filmed, and the durometer."""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.indentation.durometer import DurometerResult, durometer
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.sweep.judging.central_press import press_centrally
from magicsim.sweep.judging.measures import Measured
from magicsim.sweep.judging.quality import Quality

FORCE_DEPTH_MM = 1.0
COARSER = (0.5, 0.75)
"""Cells across the contact of the lattices that a force is compared with, in units of its own."""
DUROMETER_COARSENING = 1.5
"""Ratio of the spacings that hardness is compared at; a lattice twice as coarse as a preview's has no node inside the
rim of the cone's tip."""
DUROMETER_STEP_MM = 0.25
"""Load step of the cone, twice the usual one, which changes the hardness by less than the coarser lattice does [mm]."""
DUROMETER_TOLERANCE_N = 4e-3
"""Tolerance of the force at equilibrium [N]: 0.05 units of Shore A."""


def press_curve(depths_mm: Array, force_n: Array, *, relative_error: float) -> tuple[Measured, Measured]:
    """Force at 1 mm [N], and stiffness from the depth before it [N/mm].

    Args:
        depths_mm: Rising, 1 mm among them, shape (depths,) [mm].
        force_n: Shape (depths,) [N].
        relative_error: Of the force, by the lattice's spacing.
    """
    place = int(np.flatnonzero(depths_mm == FORCE_DEPTH_MM)[0])
    force = float(force_n[place])
    stiffness = float((force - force_n[place - 1]) / (depths_mm[place] - depths_mm[place - 1]))
    return _between(force, relative_error), _between(stiffness, relative_error)


def spacing_error(design: ElastomerDesign, thing: ObjectConfig, force_n: float, *, cells_across: int) -> float:
    """Relative error of a force at 1 mm by the lattice's spacing: the largest change that coarser lattices make.

    On such coarse lattices the force does not fall or rise steadily with the spacing, so that one of them may agree by
    chance. A lattice half as fine again changed the force on a block of the base design by less
    (`tests/unit/sweep/test_mechanics.py`).

    Raises:
        ConvergenceError: A coarse lattice finds no equilibrium.
    """
    coarse = [
        press_centrally(design, thing, FORCE_DEPTH_MM, cells_across=round(share * cells_across)).force_n[2]
        for share in COARSER
    ]
    return max(abs(float(each) - force_n) / force_n for each in coarse)


def hardness(design: ElastomerDesign, quality: Quality) -> Measured:
    """Shore A with the change that a coarser lattice makes; none where no equilibrium is found."""
    try:
        fine = _durometer(design, quality, quality.durometer_spacing_mm)
    except ConvergenceError as error:
        return Measured(value=None, note=str(error))
    note = f"walls below the cone {fine.walls}" if fine.walls != "none" else ""
    try:
        other = _durometer(design, quality, DUROMETER_COARSENING * quality.durometer_spacing_mm)
    except ConvergenceError:
        return Measured(value=fine.shore_a, note=note)
    if other.unknowns == fine.unknowns:  # the printed planes leave no coarser lattice
        return Measured(value=fine.shore_a, note=note)
    half = abs(fine.shore_a - other.shore_a)
    return Measured(value=fine.shore_a, low=fine.shore_a - half, high=fine.shore_a + half, note=note)


def _durometer(design: ElastomerDesign, quality: Quality, spacing_mm: float) -> DurometerResult:
    return durometer(
        design,
        spacing_mm=spacing_mm,
        walls=quality.durometer_walls,
        step_mm=DUROMETER_STEP_MM,
        force_tolerance_n=DUROMETER_TOLERANCE_N,
    )


def _between(value: float, relative_error: float) -> Measured:
    half = abs(value) * relative_error
    return Measured(value=value, low=value - half, high=value + half)
