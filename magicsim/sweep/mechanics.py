"""How hard a design is, and what it bears: presses in the middle of the face, and the durometer.

Each depth is pressed on a lattice of its own, as fine as the contact is small, so that the lightest touch is as well
resolved as the deepest one; it holds a quarter of the block where the object is its own mirror image.

What fails first is told at the lowest strengths of the design's `limits`: designs share their materials, so that the
range of a data sheet moves all of them alike and tells none from another (`press --limits` has it).
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import partial

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation, Displacement
from magicsim.deform.indentation.bearing import Bearing, press_limits
from magicsim.deform.indentation.durometer import durometer
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.spot import QUARTERS, central_lattice, displaced_elsewhere, is_mirror_image
from magicsim.deform.lattice.structure import FINEST_MM, Lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError, MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import node_spacing_mm
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.limits import STRENGTHS
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor
from magicsim.sweep.measures import DURABILITY, Measured, SweepQuality
from magicsim.waiting import unheard

FOLLOWED_MM = 0.5
"""Node spacing of the lattice that carries displacements to the meshes: no coarser than their triangles [mm]."""
FOLLOWED_GROWTH = 1.3
"""How much wider each is than the one before it, away from a fine contact."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CentralPress:
    """One depth of one object."""

    indenter: Indenter
    lattice: Lattice
    deformation: Deformation

    @property
    def force_n(self) -> Array:
        """Force of the object on the sensor, shape (3,) [N]; across the face it is zero for a mirror image."""
        if not self.lattice.is_mirrored:
            return self.deformation.force_n
        return np.asarray(self.deformation.force_n * [0.0, 0.0, QUARTERS])

    def displacements_mm(self, points_mm: Array, place_mm: tuple[float, float] = (0.0, 0.0)) -> Array:
        """What the same press at a place does to points, shape (points, 3) [mm]."""
        return displaced_elsewhere(self.lattice, self.deformation.displacements_mm, points_mm, place_mm)


def press_centrally(
    design: ElastomerDesign, thing: ObjectConfig, depth_mm: float, *, cells_across: int, spacing_mm: float | None = None
) -> CentralPress:
    """Presses an object from rest, a depth from first contact.

    The lattice has at least `cells_across` cells across the contact of a blunt object, or the spacing that is given.

    Raises:
        ConfigError: The object does not touch.
        ConvergenceError: No valid equilibrium was found.
    """
    compile_kernels()
    indenter = place_object(thing, gap_mm=-depth_mm)
    zone = contact_zone([indenter], design)
    if zone is None:
        raise ConfigError(f"the object does not reach the face at a depth of {depth_mm:g} mm")
    spacing_mm = spacing_mm or _spacing_mm(design, zone, cells_across)
    lattice = central_lattice(design, zone, spacing_mm=spacing_mm, is_quarter=is_mirror_image(indenter))
    solver = ContactSolver(lattice, point_spacing_mm=point_spacing_mm(indenter.shape))
    return CentralPress(indenter=indenter, lattice=lattice, deformation=solver.solve(indenter))


def followed_finely(design: ElastomerDesign, *, near_mm: float | None = None) -> ElastomerDesign:
    """The design with a lattice that meshes follow and nothing is solved on.

    Even, or finer than that near the contact, with a node spacing of its own there [mm].
    """
    spacing = min(FOLLOWED_MM, design.lattice.spacing_mm or FOLLOWED_MM)
    update = {"spacing_mm": spacing, "growth": 1.0, "cells_across": 0}
    if near_mm is not None and near_mm < spacing:
        update |= {"spacing_mm": near_mm, "growth": FOLLOWED_GROWTH}
    return design.model_copy(update={"lattice": design.lattice.model_copy(update=update)})


def moved(simulated: Sensor, state: FrameState, pressed: CentralPress) -> Displacement:
    """A press in the middle, moved to where a state has its object."""
    place = (state.x_mm, state.y_mm)
    return Displacement(displacements_mm=pressed.displacements_mm(simulated.lattice.nodes_mm, place))


def _spacing_mm(design: ElastomerDesign, zone: Zone, cells_across: int) -> float:
    """Below sharp tips, which slide off single nodes of a fine lattice, the design's own spacing [mm]."""
    usual = node_spacing_mm(design)
    return min(usual, max(FINEST_MM, 2 * zone.radius_mm / cells_across)) if zone.is_blunt else usual


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
    hard, stiff = (Measured.within(each, abs(each) * relative_error) for each in (force, stiffness))
    return hard, stiff


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


def hardness(design: ElastomerDesign, quality: SweepQuality) -> Measured:
    """Shore A with the change that a coarser lattice makes; none where no equilibrium is found."""
    spacing_mm, tolerance_n = quality.durometer_spacing_mm, DUROMETER_TOLERANCE_N
    walls, step_mm = quality.durometer_walls, DUROMETER_STEP_MM
    solved = partial(durometer, design, walls=walls, step_mm=step_mm, force_tolerance_n=tolerance_n)
    try:
        fine = solved(spacing_mm=spacing_mm)
    except MagicsimError as error:
        return Measured(value=None, note=str(error))
    note = f"walls below the cone {fine.walls}" if fine.walls != "none" else ""
    try:
        other = solved(spacing_mm=DUROMETER_COARSENING * spacing_mm)
    except MagicsimError:
        return Measured(value=fine.shore_a, note=note)
    if other.unknowns == fine.unknowns:  # the printed planes leave no coarser lattice
        return Measured(value=fine.shore_a, note=note)
    return Measured.within(fine.shore_a, abs(fine.shore_a - other.shore_a), note)


LIMITS_COARSENING = 1.5
"""Ratio of the spacings that what fails first is compared at."""


def durability(design: ElastomerDesign, thing: ObjectConfig, wanted: Collection[str]) -> dict[str, Measured]:
    """What the wanted ones of `DURABILITY` are, with the change that a coarser lattice makes; one press for all."""
    events = {event for name, event in DURABILITY.items() if name in wanted and event}
    lowest = {name: (ends[0],) * 2 for name in STRENGTHS if (ends := getattr(design.limits, name)) is not None}
    weakest = design.model_copy(update={"limits": design.limits.model_copy(update=lowest)})
    try:
        fine, coarse = (
            press_limits(weakest, thing, until=events, coarsening=coarsening, told=unheard)
            for coarsening in (1.0, LIMITS_COARSENING)
        )
    except MagicsimError as error:
        return {name: Measured(value=None, note=str(error)) for name in wanted if name in DURABILITY}
    return {name: _failure(name, fine, coarse) for name in wanted if name in DURABILITY}


def _failure(name: str, fine: Bearing, coarse: Bearing) -> Measured:
    """One measure: a bound where nothing fails in the deepest place that was solved."""
    event = DURABILITY[name]
    key = "force_n" if event else "depth_mm"
    if event and not any(each.event == event for each in fine.onsets):
        return Measured(value=None, note=f"the design's limits have no strength for {event}")
    first, other = (each.first(event, 0) if event else each.recommended for each in (fine, coarse))
    if first is None:
        deepest = fine.history[-1]
        value = float(getattr(deepest, key))
        return Measured(
            value=value, low=value, note=f"at least: none down to {deepest.depth_mm:.3g} mm; {fine.stopped}"
        )
    value = float(getattr(first, key))
    if other is None:
        return Measured(value=value, note=f"by {first.by}")
    return Measured.within(value, abs(value - float(getattr(other, key))), f"by {first.by}")
