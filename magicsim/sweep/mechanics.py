"""How hard a design is: force and stiffness of the press that is filmed, and the durometer."""

import numpy as np
import numpy.typing as npt

from magicsim.deform.durometer import durometer
from magicsim.deform.face import point_spacing_mm
from magicsim.deform.lattice import lattice_on
from magicsim.deform.path import ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import lattice_planes, resolve_grid
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects import ObjectConfig
from magicsim.sweep.measures import Measured
from magicsim.sweep.quality import Quality

Array = npt.NDArray[np.float64]
FORCE_DEPTH_MM = 1.0
COARSENING = 2
"""Ratio of the spacings whose forces are compared."""


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


def spacing_error(design: ElastomerDesign, thing: ObjectConfig, force_n: float) -> float:
    """Relative error of a force at 1 mm by the lattice's spacing: how much a lattice twice as coarse changes it.

    That is the error of a method of first order, and more than that of one of higher order. Half the spacing changed
    force on a block of the base design by two thirds of it (`tests/unit/sweep/test_mechanics.py`).

    Raises:
        ConvergenceError: The coarse lattice finds no equilibrium.
    """
    grid = resolve_grid(design)
    planes = [np.asarray(each, float) for each in lattice_planes(design, grid)]
    x, y, z = (_thinned(each, design.skin_mm if design.has_grid else 0.0) for each in planes)
    indenter = place_object(thing, gap_mm=-FORCE_DEPTH_MM)
    solver = ContactSolver(lattice_on((x, y, z), design), point_spacing_mm=point_spacing_mm(indenter.shape))
    coarse = float(solver.solve(indenter).force_n[2])
    return abs(coarse - force_n) / force_n


def hardness(design: ElastomerDesign, quality: Quality) -> Measured:
    """Shore A with the change that a coarser lattice makes; none where no equilibrium is found."""
    try:
        fine = durometer(design, spacing_mm=quality.durometer_spacing_mm, walls=quality.durometer_walls)
    except ConvergenceError as error:
        return Measured(value=None, note=str(error))
    note = f"walls below the cone {fine.walls}" if fine.walls != "none" else ""
    coarser = COARSENING * quality.durometer_spacing_mm
    try:
        other = durometer(design, spacing_mm=coarser, walls=quality.durometer_walls)
    except ConvergenceError:
        return Measured(value=fine.shore_a, note=note)
    if other.unknowns == fine.unknowns:  # the printed planes leave no coarser lattice
        return Measured(value=fine.shore_a, note=note)
    half = abs(fine.shore_a - other.shore_a)
    return Measured(value=fine.shore_a, low=fine.shore_a - half, high=fine.shore_a + half, note=note)


def _between(value: float, relative_error: float) -> Measured:
    half = abs(value) * relative_error
    return Measured(value=value, low=value - half, high=value + half)


def _thinned(planes_mm: Array, skin_mm: float) -> Array:
    """Every second plane, those of the outer faces and of the core's ends kept [mm]."""
    keep = np.zeros(len(planes_mm), bool)
    keep[::COARSENING] = True
    for wanted in (planes_mm[0], planes_mm[0] + skin_mm, planes_mm[-1] - skin_mm, planes_mm[-1]):
        keep[np.abs(planes_mm - wanted).argmin()] = True
    return planes_mm[keep]
