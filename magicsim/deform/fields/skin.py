"""Stretch and stress of the skin: the layer of body between the contact face and the printed cells.

At the Gauss points of the lattice's cells, from the deformation gradient F of their trilinear map: principal stretches
are the singular values of F, and with B = F F^T and J = det F the Cauchy stress of the body's law is

    sigma = mu (B - 1) / J + sum_b mu_b (F A_b F^T - 1) / J + lambda (Jbar - 1) 1,

mu its long-term shear modulus, mu_b and A_b those of the branches of a body that relaxes (see `lattice.relaxation`).
The von Mises stress sqrt(3/2 s : s), s the deviator of sigma, does not see the last term, and is the stress of a bar
that is pulled by so much.

Gauss points lie inside the cells: what happens between the outermost of them and the surface of the skin is left out,
less of it the more cells there are across the skin (`lattice.spacing_mm`).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS, gauss_geometry
from magicsim.deform.lattice.relaxation import FULL, Branches
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign

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
        """The skin of a block; without a grid, all of it.

        Args:
            design: The block.
            lattice: Its lattice.
            branches: Those of the solver on a timed path; None for the long-term response.
        """
        depth = design.skin_mm if design.has_grid else design.height_mm
        layers = max(1, int(np.searchsorted(lattice.planes_mm[2], depth + ROUNDING_MM)) - 1)
        count = layers * (len(lattice.planes_mm[0]) - 1) * (len(lattice.planes_mm[1]) - 1)
        inverse, _ = gauss_geometry(lattice.nodes_mm[lattice.cells[:count]])
        return cls(lattice=lattice, layers=layers, inverse=inverse, branches=branches)

    def deformation_gradients(self, displacements_mm: Array) -> Array:
        """F at the Gauss points of the skin's cells, x fastest, shape (cells, 8, 3, 3).

        Args:
            displacements_mm: Of the lattice's nodes, shape (nodes, 3) [mm].
        """
        places = self.lattice.nodes_mm + displacements_mm
        corners = places[self.lattice.cells[: len(self.inverse)]].transpose(0, 2, 1)
        return np.asarray(corners[:, None] @ GAUSS_GRADIENTS @ self.inverse)

    def fields(self, deformation: Deformation) -> SkinFields:
        """Largest stretch and stress of each column of cells.

        Args:
            deformation: Of the lattice.
        """
        shape = (len(self.lattice.planes_mm[1]) - 1, len(self.lattice.planes_mm[0]) - 1)
        if deformation.is_rest:
            return SkinFields(stretch=np.ones(shape), von_mises_mpa=np.zeros(shape))
        gradients = self.deformation_gradients(deformation.displacements_mm)
        stress = von_mises_mpa(gradients, self._kirchhoff(gradients, deformation))
        return SkinFields(
            stretch=largest_stretch(gradients).max(1).reshape(self.layers, *shape).max(0),
            von_mises_mpa=stress.max(1).reshape(self.layers, *shape).max(0),
        )

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


def largest_stretch(gradients: Array) -> Array:
    """Largest principal stretch of deformation gradients of shape (..., 3, 3), shape (...)."""
    metric = gradients.swapaxes(-1, -2) @ gradients
    return np.asarray(np.sqrt(np.linalg.eigvalsh(metric)[..., -1]))


def von_mises_mpa(gradients: Array, kirchhoff_mpa: Array) -> Array:
    """Von Mises stress of Cauchy's stress, shape (...) [MPa].

    Args:
        gradients: Deformation gradients, shape (..., 3, 3).
        kirchhoff_mpa: Kirchhoff's stress, up to an isotropic part, shape (..., 3, 3) [MPa].
    """
    mean = np.trace(kirchhoff_mpa, axis1=-2, axis2=-1) / 3
    deviator = kirchhoff_mpa - mean[..., None, None] * np.eye(3)
    size = np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))
    return np.asarray(size / np.linalg.det(gradients))
