"""Strain that an equilibrium leaves in the block: stretch and stress of the skin, and shear of the infill.

**Skin**, the layer of body between the contact face and the printed cells, at the Gauss points of the lattice's cells,
from the deformation gradient F of their trilinear map; `docs/physics/mechanics.md` has Cauchy's stress sigma. The von
Mises stress does not see its term of volume, and is the stress of a bar that is pulled by so much. What happens between
the outermost Gauss points and the surface of the skin is left out, less of it the more cells there are across the skin.

What tears a skin is told of its two sides (`SkinCells.strained`). In the middle of a cell F is second-order accurate
and free of the modes in which single cells fold; F and the pressure p = lambda (Jbar - 1) there go on to each side by
the line through the two layers next to it. With l the principal stretches the principal nominal stresses, forces over
areas at rest as a tensile test has them, are

    P_i = (J / l_i) (mu (l_i^2 - 1) / J + p).

**Infill.** The lattice carries whole printed cells: walls and infill together. With F = R U the mean deformation
gradient of a printed cell, its infill has on average the logarithmic strain E = A : ln U. A comes from the same
periodic cell problem as the cell's stiffness and says how much more than the cell the soft infill strains between
stiffer walls: three numbers of a cubic tensor, exact for small strain, carried on to large ones by the logarithm, which
keeps a nearly incompressible infill incompressible.

The shear is gamma = sqrt(tr exp(2 E') - 3), E' the deviator of E: the amount of shear of a simple shear, whose
neo-Hookean energy is mu gamma^2 / 2. A gel of the yield stress tau (von Mises' criterion) begins to flow where mu gamma
= tau. The mean over an infill cube is meant; beside the edges of the walls it is sheared more.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.cell_problem import CellFields, printed_fields
from magicsim.deform.lattice.follow import mean_gradient, rotation_and_strain
from magicsim.deform.lattice.hexahedron import deformation_gradients, gauss_geometry
from magicsim.deform.lattice.relaxation import FULL, Branches
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.yielding import amount_of_shear
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid

ROUNDING_MM = 1e-6
"""Slack of the plane between skin and core [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SkinFields:
    """Largest values in each column of skin cells."""

    stretch: Array
    """Largest principal stretch, 1 at rest, shape (ny, nx)."""
    von_mises_mpa: Array
    """Largest von Mises stress, shape (ny, nx) [MPa]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SkinCells:
    """The cells of the skin with all that does not change from state to state."""

    lattice: Lattice
    layers: int
    """Layers of cells across the skin."""
    inverse: Array
    """Inverse Jacobian of the rest map at the Gauss points, shape (cells, 8, 3, 3) [1/mm]."""
    branches: Branches | None
    """Relaxation of the body on a timed path."""

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice, *, branches: Branches | None = None) -> Self:
        """The skin of a block; without a grid, all of it."""
        depth = design.skin_mm if design.has_grid else design.height_mm
        layers = max(1, int(np.searchsorted(lattice.planes_mm[2], depth + ROUNDING_MM)) - 1)
        count = layers * (len(lattice.planes_mm[0]) - 1) * (len(lattice.planes_mm[1]) - 1)
        inverse, _ = gauss_geometry(lattice.nodes_mm[lattice.cells[:count]])
        return cls(lattice=lattice, layers=layers, inverse=inverse, branches=branches)

    def deformation_gradients(self, displacements_mm: Array) -> Array:
        """F at the Gauss points of the skin's cells, x fastest, shape (cells, 8, 3, 3), from nodal displacements."""
        places = self.lattice.nodes_mm + displacements_mm
        return deformation_gradients(places, self.lattice.cells[: len(self.inverse)], self.inverse)

    def fields(self, deformation: Deformation) -> SkinFields:
        """Largest stretch and stress of each column of cells."""
        shape = (len(self.lattice.planes_mm[1]) - 1, len(self.lattice.planes_mm[0]) - 1)
        if deformation.is_rest:
            return SkinFields(stretch=np.ones(shape), von_mises_mpa=np.zeros(shape))
        gradients = self.deformation_gradients(deformation.displacements_mm)
        stretch = np.sqrt(np.linalg.eigvalsh(gradients.swapaxes(-1, -2) @ gradients)[..., -1])  # principal, largest
        stress = von_mises_mpa(gradients, self._kirchhoff(gradients, deformation))
        return SkinFields(
            stretch=stretch.max(1).reshape(self.layers, *shape).max(0),
            von_mises_mpa=stress.max(1).reshape(self.layers, *shape).max(0),
        )

    def strained(self, deformation: Deformation) -> tuple[float, float]:
        """Largest principal stretch and largest principal nominal stress [MPa] on the two sides of the skin."""
        if deformation.is_rest:
            return 1.0, 0.0
        count = len(self.inverse)
        middles = self.deformation_gradients(deformation.displacements_mm).mean(1)
        gradients = self._on_sides(middles.reshape(self.layers, -1, 3, 3))
        pressure = self._on_sides(deformation.pressure_mpa[:count].reshape(self.layers, -1))
        stretches = np.linalg.svd(gradients, compute_uv=False)
        jacobian = stretches.prod(-1)
        modulus = self.lattice.shear_modulus_mpa[: gradients.shape[1], None]
        stress = modulus * (stretches - 1 / stretches) + (jacobian * pressure)[..., None] / stretches
        return float(stretches.max()), float(stress.max())

    def _on_sides(self, values: Array) -> Array:
        """Values in the middles of cells, shape (layers, columns, ...), on the face and the core's side of the skin."""
        if self.layers == 1:
            return values
        edges = np.diff(self.lattice.planes_mm[2])[: self.layers]
        outer, inner = edges[0] / (edges[0] + edges[1]), edges[-1] / (edges[-1] + edges[-2])
        return np.stack([
            values[0] + outer * (values[0] - values[1]), values[-1] + inner * (values[-1] - values[-2]),
        ])  # fmt: skip

    def _kirchhoff(self, f: Array, deformation: Deformation) -> Array:
        """J times the Cauchy stress but for its isotropic part, shape (cells, 8, 3, 3) [MPa]."""
        transposed = f.transpose(0, 1, 3, 2)
        count = len(self.inverse)
        stress = self.lattice.shear_modulus_mpa[:count, None, None, None] * (f @ transposed)
        if self.branches is not None and deformation.relaxation is not None:
            moduli = self.branches.shear_modulus_mpa[:, :count, None, None]
            network = (moduli * deformation.relaxation.tensors[:, :count]).sum(0)
            stress += f @ network[..., FULL] @ transposed
        return np.asarray(stress)


def von_mises_mpa(gradients: Array, kirchhoff_mpa: Array) -> Array:
    """Von Mises stress of Cauchy's stress, shape (...) [MPa].

    From deformation gradients and Kirchhoff's stress, up to an isotropic part, of shape (..., 3, 3).
    """
    mean = np.trace(kirchhoff_mpa, axis1=-2, axis2=-1) / 3
    deviator = kirchhoff_mpa - mean[..., None, None] * np.eye(3)
    size = np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))
    return np.asarray(size / np.linalg.det(gradients))


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
        """Strain of the infill from symmetric strains of the cells, both of shape (count, 3, 3)."""
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
    def of(cls, design: ElastomerDesign, lattice: Lattice, *, corners_mm: Array | None = None) -> Self | None:
        """The infill of a block, or None where it has none.

        `corners_mm` are the corners of smallest x, y and z of other cells than the printed ones, shape (cells, 3) [mm]:
        a core of effective cells has them anywhere.
        """
        grid = lattice.grid
        fields = printed_fields(design, grid)
        if grid is None or fields is None:
            return None
        corners = grid.centres_mm() - grid.pitch_mm / 2 if corners_mm is None else corners_mm
        return cls(
            grid=grid,
            gradient=mean_gradient(lattice, corners, grid.pitch_mm, design),
            localisation=localisation(fields),
        )

    def shear(self, deformation: Deformation) -> Array:
        """Shear gamma of each infill cube, 0 at rest, shape (nz, ny, nx): the layer below the skin first."""
        return self.shears(deformation.displacements_mm).reshape(self.grid.counts[::-1])

    def shears(self, displacements_mm: Array) -> Array:
        """Shear gamma of each cell from nodal displacements, shape (cells,)."""
        gradient = np.asarray(self.gradient @ displacements_mm).reshape(-1, 3, 3)
        _, strain = rotation_and_strain(np.eye(3) + gradient.transpose(0, 2, 1))
        return shear_of(self.localisation.applied(strain))


def shear_of(strain: Array) -> Array:
    """Amount of shear sqrt(tr exp(2 E') - 3) of logarithmic strains of shape (count, 3, 3), shape (count,)."""
    principal = np.linalg.eigvalsh(strain)
    return amount_of_shear(principal - principal.mean(1, keepdims=True))


def localisation(fields: CellFields) -> Localisation:
    """Mean strain of the infill from the solution of the cell problem.

    The mean of a gradient over the infill is the flux of the displacement through its surface; of the eighth of the
    cell that is solved, mirrors leave the faces of the wall and of the middle.
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
