"""An object pressed at the middle of the face, each depth on a lattice of its own: what every touch of a film takes.

The lattice is as fine as the contact is small, so that the lightest touch is as well resolved as the deepest one, and
holds a quarter of the block where the object is its own mirror image.
"""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation, Displacement
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.spot import QUARTERS, central_lattice, displaced_elsewhere, is_mirror_image
from magicsim.deform.lattice.structure import FINEST_MM, Lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import node_spacing_mm
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.scenes.timeline import FrameState
from magicsim.simulation.sensor import Sensor

FOLLOWED_MM = 0.5
"""Node spacing of the lattice that carries displacements to the meshes: no coarser than their triangles [mm]."""


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
    design: ElastomerDesign,
    thing: ObjectConfig,
    depth_mm: float,
    *,
    cells_across: int,
    spacing_mm: float | None = None,
) -> CentralPress:
    """Presses an object from rest.

    Args:
        design: The block.
        thing: The object.
        depth_mm: From first contact [mm].
        cells_across: Least number of lattice cells across the contact of a blunt object.
        spacing_mm: Node spacing below the object instead of that [mm].

    Raises:
        ConfigError: The object does not touch.
        ConvergenceError: No valid equilibrium was found.
    """
    compile_kernels()
    indenter = place_object(thing, gap_mm=-depth_mm)
    zone = contact_zone([indenter], design)
    if zone is None:
        msg = f"the object does not reach the face at a depth of {depth_mm:g} mm"
        raise ConfigError(msg)
    lattice = central_lattice(
        design,
        zone,
        spacing_mm=spacing_mm or _spacing_mm(design, zone, cells_across),
        is_quarter=is_mirror_image(indenter),
    )
    solver = ContactSolver(lattice, point_spacing_mm=point_spacing_mm(indenter.shape))
    return CentralPress(indenter=indenter, lattice=lattice, deformation=solver.solve(indenter))


def followed_finely(design: ElastomerDesign) -> ElastomerDesign:
    """The design with an even lattice that meshes follow and nothing is solved on."""
    spacing = min(FOLLOWED_MM, design.lattice.spacing_mm or FOLLOWED_MM)
    update = {"spacing_mm": spacing, "growth": 1.0, "cells_across": 0}
    return design.model_copy(update={"lattice": design.lattice.model_copy(update=update)})


def moved(simulated: Sensor, state: FrameState, pressed: CentralPress) -> Displacement:
    """A press in the middle, moved to where a state has its object."""
    place = (state.x_mm, state.y_mm)
    return Displacement(displacements_mm=pressed.displacements_mm(simulated.lattice.nodes_mm, place))


def _spacing_mm(design: ElastomerDesign, zone: Zone, cells_across: int) -> float:
    """Below sharp tips, which slide off single nodes of a fine lattice, the design's own spacing [mm]."""
    usual = node_spacing_mm(design)
    return min(usual, max(FINEST_MM, 2 * zone.radius_mm / cells_across)) if zone.is_blunt else usual
