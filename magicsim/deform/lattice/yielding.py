"""Infill that flows: a branch of the core's stiffness that carries a bounded stress, with its dent and its heat.

Of the effective shear modulus of a core cell the part Delta mu is the infill's: what the cell problem loses when the
infill carries no shear (the nearest isotropic modulus, mu + 2/5 beta). That part is a network with a natural inverse
metric A at each Gauss point, 1 at rest, as the branches of `lattice.relaxation` have:

    W = ... + Delta mu / 2 (tr(F A F^T) - tr(F F^T)),   tau = Delta mu (b - 1),   b = F A F^T.

With e' the deviator of ln b / 2 its elastic shear is gamma = sqrt(tr exp(2 e') - 3), the amount of a simple shear, and
the infill's own is k gamma: the energies phi mu_i (k gamma)^2 / 2 of infill in the share phi of the volume and of the
network agree for k = sqrt(Delta mu / (phi mu_i)). The infill flows at the shear stress tau_y where mu_i k gamma = tau_y
(von Mises); e' is then scaled back to that surface at a fixed F (radial return, Simo 1992), which leaves det A = 1. It
is perfectly plastic: no hardening and no rate. What is dissipated per volume at rest, tau : (1 - s) e' with s the
scale, is never negative, since b_i grows with e_i.

Left out: that the infill loses less along the walls than across (the drop of the modulus is 14 % too small in shear
between the walls and 32 % too large along them in `mini-magictac`), that an infill that flows in one corner of its cell
does not yet in another.

Reference: Simo, Comput. Meth. Appl. Mech. Eng. 99 (1992) 61.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.config.ranges import check_number
from magicsim.deform.lattice.cell_problem import printed_fields
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import deformation_gradients, network_matrices
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.tearing import NO_SHEAR
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign

MOST_YIELD_MPA = 10.0
HALVINGS = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class FlowLaw:
    """The part of a lattice's stiffness that flows."""

    cells: Index
    """Cells with infill, shape (cells,)."""
    modulus_mpa: float
    """Delta mu [MPa]."""
    shear: float
    """Elastic shear gamma at which the infill flows."""

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice, yield_mpa: float | None) -> Self | None:
        """The law of a design's infill that yields at a shear stress [MPa]; None where it never does."""
        if yield_mpa is None:
            return None
        check_number("infill_yield_mpa", yield_mpa, 1e-6, MOST_YIELD_MPA)
        infill, grid = design.materials.infill, lattice.grid
        whole, flowing = printed_fields(design, grid), printed_fields(design, grid, gel=NO_SHEAR)
        if infill is None or grid is None or whole is None or flowing is None:
            raise ConfigError(
                f"infill_yield_mpa = {yield_mpa:g} is not allowed for a block without infill (cell_mm = 0)"
            )
        share = float(np.prod(grid.cell_mm / grid.pitch_mm))
        full, left = (each.stiffness.isotropic_modulus_mpa for each in (whole, flowing))
        more = np.sqrt((full - left) / (share * infill.shear_modulus_mpa))
        return cls(
            cells=np.flatnonzero(lattice.is_core),
            modulus_mpa=full - left,
            shear=float(yield_mpa / infill.shear_modulus_mpa / more),
        )

    def rest(self) -> Array:
        """Metrics A of an infill that has never flowed, shape (cells, 8, 3, 3)."""
        return np.tile(np.eye(3), (len(self.cells), 8, 1, 1))

    def flowed(self, elasticity: Elasticity, tensors: Array) -> Elasticity:
        """The energy of a lattice with its infill as it has flowed, metrics of shape (cells, 8, 3, 3)."""
        network = self._moduli_mpa(elasticity)[:, None, None, None] * (tensors - np.eye(3))
        springs = elasticity.springs.copy()
        springs[self.cells] += network_matrices(elasticity.inverse[self.cells], elasticity.weights[self.cells], network)
        return replace(elasticity, springs=springs)

    def advanced(self, elasticity: Elasticity, tensors: Array, positions: Array) -> tuple[Array, float]:
        """Metrics after a step to node positions, shape (nodes, 3) [mm], and the heat that flows on it [N mm]."""
        f = deformation_gradients(positions, elasticity.lattice.cells[self.cells], elasticity.inverse[self.cells])
        values, axes = np.linalg.eigh(f @ tensors @ f.swapaxes(-1, -2))
        strain = np.log(values) / 2
        mean = strain.mean(-1, keepdims=True)
        deviator = strain - mean
        flows = amount_of_shear(deviator) > self.shear
        if not flows.any():
            return tensors, 0.0
        deviator, mean, axes, f = deviator[flows], mean[flows], axes[flows], f[flows]
        scale = _scale(deviator, self.shear)[:, None]
        metric = np.exp(2 * (mean + scale * deviator))
        inverse = np.linalg.inv(f) @ axes
        changed = tensors.copy()
        changed[flows] = (inverse * metric[:, None]) @ inverse.swapaxes(-1, -2)
        weights = (self._moduli_mpa(elasticity)[:, None] * elasticity.weights[self.cells])[flows]
        return changed, float((((1 - scale) * deviator * metric).sum(1) * weights).sum())

    def _moduli_mpa(self, elasticity: Elasticity) -> Array:
        """Delta mu of each cell, shape (cells,) [MPa]; no more than what a cell has left that is torn."""
        return np.minimum(self.modulus_mpa, elasticity.log_modulus_mpa[self.cells])


def amount_of_shear(deviator: Array) -> Array:
    """Amount of a simple shear with these principal logarithmic strains without their mean, shape (..., 3)."""
    return np.asarray(np.sqrt(np.maximum(np.exp(2 * deviator).sum(-1) - 3, 0.0)))


def _scale(deviator: Array, shear: float) -> Array:
    """Factors in 0..1 that bring strains of shape (count, 3) to an amount of shear, shape (count,)."""
    low, high = np.zeros(len(deviator)), np.ones(len(deviator))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        is_above = amount_of_shear(middle[:, None] * deviator) > shear
        low, high = np.where(is_above, low, middle), np.where(is_above, middle, high)
    return low
