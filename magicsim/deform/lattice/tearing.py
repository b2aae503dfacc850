"""Walls that tear: printed cells whose walls carry nothing once they are stretched to their elongation at break.

A wall is as thin as a few droplets and as wide as its cell, so that a printed cell is the least that tears: its walls
are whole or gone. The stretch of a cell is the largest principal one in the plane of any of its three walls, by the
mean deformation gradient of the printed cell, whatever the lattice's spacing. That makes a length of the print, and not
the mesh, the width of a tear. What is left of a torn cell is its infill in walls that carry no shear, as the cell
problem has it (the nearest isotropic modulus, mu + 2/5 beta); its volume still resists, as that of a liquid in a skin.

Tearing is brittle, does not heal, and takes one cell after another: of those that are stretched too far the most
stretched ones tear, the others if they still are in the next equilibrium at that place of the object. The energy that
the block loses then is heat (`core_failure`).

Assumed: a cell tears as a whole, and at the elongation of the bulk that its walls are printed of; thin walls may bear
less. Left out: tears that grow from a notch at less, and light in torn walls. `torn_share` has walls missing in print.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.config.ranges import check_number
from magicsim.deform.lattice.cell_problem import printed_fields
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import deformation_gradients
from magicsim.deform.lattice.structure import Lattice
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign

LEAST_ELONGATION, MOST_ELONGATION = 0.05, 10.0
NO_SHEAR = 1e-3
"""Shear modulus of what is torn or flows, in units of its own."""
TOGETHER = 1e-3
"""Relative difference of stretches that tear at once: cells that mirror each other differ by rounding."""
IN_WALL = ((1, 2), (0, 2), (0, 1))
"""Axes in the plane of the walls across x, y and z."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TearLaw:
    """Which cells of a lattice belong to which printed cell, and at what stretch its walls tear."""

    cells: Index
    """Core cells of the lattice, shape (cells,)."""
    printed: Index
    """Number of the printed cell that each of them lies in, shape (cells,); as many as there are, from 0 on."""
    stretch: float
    """Stretch at which walls tear: 1 plus the elongation at break."""
    modulus_mpa: float
    """Shear modulus of a torn cell [MPa]."""

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice, elongation: float | None) -> Self | None:
        """The law of a design whose walls tear at an elongation (1 is twice as long); None where they never do."""
        if elongation is None:
            return None
        check_number("wall_tear_elongation", elongation, LEAST_ELONGATION, MOST_ELONGATION)
        grid, torn = lattice.grid, printed_fields(design, lattice.grid, walls=NO_SHEAR)
        if grid is None or torn is None:
            raise ConfigError(
                f"wall_tear_elongation = {elongation:g} is not allowed for a block without walls (cell_mm = 0)"
            )
        cells = np.flatnonzero(lattice.is_core)
        centres = lattice.flattened(lattice.nodes_mm)[lattice.cells[cells]].mean(1)
        place = np.floor((centres - grid.origin_mm) / grid.pitch_mm).astype(np.int64)
        _, printed = np.unique(place, axis=0, return_inverse=True)
        return cls(
            cells=cells,
            printed=printed.reshape(-1),
            stretch=1 + elongation,
            modulus_mpa=torn.stiffness.isotropic_modulus_mpa,
        )

    def whole(self) -> Array:
        """No printed cell torn, shape (printed cells,)."""
        return np.zeros(int(self.printed.max(initial=-1)) + 1)

    def left(self, elasticity: Elasticity, torn: Array) -> Elasticity:
        """The energy of a lattice whose printed cells have torn to a share, shape (printed cells,); itself if none."""
        if not torn.any():
            return elasticity
        lost, modulus = torn[self.printed], elasticity.log_modulus_mpa[self.cells]
        kept = 1 - lost * (1 - self.modulus_mpa / modulus)
        springs, moduli, walls = elasticity.springs.copy(), elasticity.log_modulus_mpa.copy(), elasticity.walls.copy()
        springs[self.cells] *= kept[:, None, None]
        moduli[self.cells] *= kept
        walls[self.cells] *= 1 - lost
        return replace(elasticity, springs=springs, log_modulus_mpa=moduli, walls=walls)

    def stretches(self, elasticity: Elasticity, positions: Array) -> Array:
        """Largest stretch in the walls of each printed cell at node positions of shape (nodes, 3) [mm]."""
        cells, inverse = elasticity.lattice.cells[self.cells], elasticity.inverse[self.cells]
        gradients = deformation_gradients(positions, cells, inverse)
        weights = elasticity.weights[self.cells]
        sums = np.zeros((len(self.whole()), 3, 3))
        np.add.at(sums, self.printed, np.einsum("cg,cgij->cij", weights, gradients))
        volumes = np.bincount(self.printed, weights.sum(1), len(sums))
        mean = sums / volumes[:, None, None]
        squares = mean.swapaxes(1, 2) @ mean
        walls = [np.linalg.eigvalsh(squares[:, axes][:, :, axes])[:, -1] for axes in IN_WALL]
        return np.asarray(np.sqrt(np.max(walls, 0)))

    def next(self, elasticity: Elasticity, torn: Array, positions: Array) -> Index:
        """Printed cells that tear next at an equilibrium, the most stretched of those that are stretched too far."""
        stretches = np.where(torn > 0, 0.0, self.stretches(elasticity, positions))
        most = float(stretches.max(initial=0.0))
        return np.flatnonzero(stretches >= most * (1 - TOGETHER)) if most >= self.stretch else np.empty(0, np.int64)
