"""Shear of the infill: how far the soft filling of each printed cell is from its shape at rest.

The lattice carries whole printed cells: walls and infill together. With F = R U the mean deformation gradient of a
printed cell, its infill has on average the logarithmic strain E = A : ln U. A comes from the same periodic cell problem
as the cell's stiffness and says how much more than the cell the soft infill strains between stiffer walls: three
numbers of a cubic tensor, exact for small strain, carried on to large ones by the logarithm, which keeps a nearly
incompressible infill incompressible.

The shear is gamma = sqrt(tr exp(2 E') - 3), E' the deviator of E: the amount of shear of a simple shear, and where the
infill's shear modulus is mu, its neo-Hookean energy is mu gamma^2 / 2. A gel with a yield stress in shear tau (von
Mises' criterion) begins to flow where mu gamma = tau. The mean over an infill cube is meant; beside the edges of the
walls it is sheared more.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.cell_correctors import mean_gradient, rotation_and_strain
from magicsim.deform.lattice.cell_problem import CellFields, printed_fields
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid


@dataclass(frozen=True, slots=True, kw_only=True)
class Localisation:
    """Mean strain of the infill for a unit mean strain of its cell: a cubic tensor."""

    along: float
    """Strain of the infill, xx under xx."""
    across: float
    """Strain of the infill, yy under xx."""
    shear: float
    """Strain of the infill, xy under xy."""

    def applied(self, strain: Array) -> Array:
        """Strain of the infill, shape (count, 3, 3).

        Args:
            strain: Of the cells, symmetric, shape (count, 3, 3).
        """
        diagonal = np.diagonal(strain, axis1=1, axis2=2)
        own = (self.along - self.across) * diagonal + self.across * diagonal.sum(1, keepdims=True)
        return np.asarray(self.shear * strain + (own - self.shear * diagonal)[:, :, None] * np.eye(3))


@dataclass(frozen=True, slots=True, kw_only=True)
class InfillCells:
    """The printed cells with all that does not change from state to state."""

    grid: CellGrid
    gradient: sp.csr_matrix
    """Mean displacement gradient of each printed cell from nodal displacements, shape (3 cells, nodes) [1/mm]."""
    localisation: Localisation

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice) -> Self | None:
        """The infill of a block, or None where it has none.

        Args:
            design: The block.
            lattice: Its lattice, with the effective stiffness of the core.
        """
        grid = lattice.grid
        fields = printed_fields(design, grid)
        if grid is None or fields is None:
            return None
        corners = grid.centres_mm() - grid.pitch_mm / 2
        return cls(
            grid=grid,
            gradient=mean_gradient(lattice, corners, grid.pitch_mm, design),
            localisation=localisation(fields),
        )

    def shear(self, deformation: Deformation) -> Array:
        """Shear gamma of each infill cube, 0 at rest, shape (nz, ny, nx): the layer below the skin first.

        Args:
            deformation: Of the lattice.
        """
        nx, ny, nz = self.grid.counts
        if deformation.is_rest:
            return np.zeros((nz, ny, nx))
        gradient = np.asarray(self.gradient @ deformation.displacements_mm).reshape(-1, 3, 3)
        _, strain = rotation_and_strain(np.eye(3) + gradient.transpose(0, 2, 1))
        return shear_of(self.localisation.applied(strain)).reshape(nz, ny, nx)


def shear_of(strain: Array) -> Array:
    """Amount of shear sqrt(tr exp(2 E') - 3) of logarithmic strains of shape (count, 3, 3), shape (count,)."""
    principal = np.linalg.eigvalsh(strain)
    deviator = principal - principal.mean(1, keepdims=True)
    return np.asarray(np.sqrt(np.maximum(np.exp(2 * deviator).sum(1) - 3, 0.0)))


def localisation(fields: CellFields) -> Localisation:
    """Mean strain of the infill from the solution of the cell problem.

    The mean of a gradient over the infill is the flux of the displacement through its surface; of the eighth of the
    cell that is solved, mirrors leave the faces of the wall and of the middle.

    Args:
        fields: Solution of the cell problem.
    """
    start = int(np.searchsorted(fields.planes, fields.half_wall - 1e-12))
    axial, shear = (each[start:, start:, start:] for each in (fields.axial, fields.shear))
    edges = np.diff(fields.planes[start:])

    def mean_slope(values: Array, axis: int) -> float:
        """Mean of the derivative along x, y or z of values at the nodes, shape (n, n, n) over z, y, x."""
        place = 2 - axis
        rise = np.take(values, -1, place) - np.take(values, 0, place)
        middles = (rise[1:, 1:] + rise[1:, :-1] + rise[:-1, 1:] + rise[:-1, :-1]) / 4
        length = float(edges.sum())
        return float((middles * edges[:, None] * edges).sum() / length**3)

    both = mean_slope(shear[..., 0], 1) + mean_slope(shear[..., 1], 0)
    return Localisation(along=1 + mean_slope(axial[..., 0], 0), across=mean_slope(axial[..., 1], 1), shear=1 + both)
