"""Shear of infill that has cells of the lattice for itself, as below the spot of `resolved_lattice`."""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.lattice.follow import rotation_and_strain
from magicsim.deform.lattice.hexahedron import shape_gradients
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.strain import shear_of


def layer_shear(lattice: Lattice, displacements_mm: Array, place_mm: tuple[float, float]) -> Array:
    """Mean shear of each layer of the uppermost infill cube below a place, the one next to the skin first.

    Args:
        lattice: Of a block, from `resolved_lattice`, walls resolved there.
        displacements_mm: Of the nodes, shape (nodes, 3) [mm].
        place_mm: x and y [mm].

    Returns:
        Amounts of shear as `magicsim.deform.strain` has them, shape (layers,); empty without infill.
    """
    grid = lattice.grid
    if grid is None:
        return np.empty(0)
    corners = lattice.nodes_mm[lattice.cells]
    middles = corners.mean(1)
    first = np.floor((np.array(place_mm) - grid.origin_mm[:2]) / grid.pitch_mm[:2])
    centre = grid.origin_mm + (np.array([*first, 0.0]) + 0.5) * grid.pitch_mm
    inside = np.flatnonzero((np.abs(middles - centre) < grid.cell_mm / 2).all(1))
    moved = corners[inside] + displacements_mm[lattice.cells[inside]]
    slopes = shape_gradients(np.full((1, 3), 0.5))[0]  # in the middle of a trilinear cell is the mean of it
    rest, now = (np.einsum("cpi,pk->cik", each, slopes) for each in (corners[inside], moved))
    shear = shear_of(rotation_and_strain(now @ np.linalg.inv(rest))[1])
    volume, depth = lattice.sizes_mm[inside].prod(1), np.round(middles[inside, 2], 9)
    return np.array([np.average(shear[depth == each], weights=volume[depth == each]) for each in np.unique(depth)])
