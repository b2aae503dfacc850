"""Rate dependence: Maxwell branches beside the long-term springs, one hyperelastic problem a time step.

Each branch is a transient Gaussian network (Green and Tobolsky 1946): chains break at the rate 1/tau and form again
free of stress in the shape of that moment. With F the deformation gradient and C = F^T F, chains formed at time s store
mu/2 tr(F C(s)^-1 F^T), so a branch is known by one tensor A, the natural inverse metric of its chains:

    A(t) = e^(-t/tau) I + int_0^t C(s)^-1 e^(-(t-s)/tau) ds / tau,   that is   dA/dt = (C^-1 - A) / tau,
    W = mu/2 (tr(F A F^T) - 3) - mu ln J - mu/2 ln det A,            P = mu (F A - F^-T),

the linear evolution of Lubliner (1985). A branch is free of stress when A = C^-1. The last term of W moves no force; it
makes the dissipation mu/(2 tau) (tr(A C) + tr((A C)^-1) - 6) >= 0, because A C has positive eigenvalues. A and C do not
change with a superposed rotation.

Over a step dt with C^-1 linear in time the evolution is exact (Taylor, Pister and Goudreau 1970; Simo 1987 does the
same for stresses). With x = dt/tau and m = (1 - e^-x)/x

    A_1 = B + (1 - m) C_1^-1,   B = e^-x A_0 + (m - e^-x) C_0^-1.

Since F C^-1 = F^-T the new stress is P = mu (F B - m F^-T): a network of tensor mu B, known before the step, with the
logarithm's factor mu m. So a step is a hyperelastic problem as before, second-order accurate in dt, exact for steps
(dt = 0) and for C^-1 that is linear in time. The networks share the cells' springs and -ln J.

The tensors live at the Gauss points, but the springs of a box cell are another quadrature rule than these: stiffer by a
matrix H that only sees what is not affine. A branch keeps that excess, or its force at 1 mm spacing would be some
percent below that of the same modulus in the long term. Its corners x have the natural places Z, averaged over the past
like A from Y = x Fm^-T (Fm: the cell's mean deformation gradient), and the excess sees x - Z Fm^T. With B of Z in place
of A, the step adds mu m S^T H S, S = 1 - (B/m) G^T (G: mean gradients of the corners): symmetric, free of force when
relaxed, zero in cells that are no boxes; of first order in dt where the deformation inside a cell is not affine.

A branch is a solid of moduli mu and lambda = 0: it adds 2/3 mu to the bulk modulus while it lives, and the pressure
term with the lattice's lambda does not relax. A body stays nearly incompressible only if lambda is large beside the sum
of all branches' moduli, not beside the long-term one. Where a Gauss point is squeezed below J = 0.01
(`cell_kernels.LOG_LIMIT`) a branch does not relax to zero stress there.

References: Green and Tobolsky, J. Chem. Phys. 14 (1946) 80; Lubliner, Mech. Res. Commun. 12 (1985) 93; Taylor, Pister
and Goudreau, Int. J. Numer. Meth. Eng. 2 (1970) 45; Simo, Comput. Meth. Appl. Mech. Eng. 60 (1987) 153.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.lattice.cell_problem import printed_fields
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS, deformation_gradients, network_matrices
from magicsim.deform.lattice.structure import Lattice
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign

ROWS = np.array([0, 1, 2, 1, 0, 0])
"""Row of each stored component of a symmetric tensor: xx, yy, zz, yz, xz, xy."""
COLUMNS = np.array([0, 1, 2, 2, 2, 1])
"""Column of each stored component."""
FULL = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
"""Stored component of each entry."""
UNIT = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
"""The unit tensor."""
LEAST_POISSON = 0.45
"""Least instantaneous Poisson's ratio: below, the bulk modulus is too small for the instantaneous stiffness;
assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Branches:
    """Relaxation times and the stiffness that each adds to the cells."""

    times_s: Array
    """Relaxation time tau of each branch, shape (branches,) [s]."""
    shear_modulus_mpa: Array
    """Shear modulus mu of each branch in each cell, beyond the long-term one, shape (branches, cells) [MPa]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxationState:
    """Memory of the branches at the end of a time step; 0.6 kB a branch and cell."""

    tensors: Array
    """A of each branch at the Gauss points, shape (branches, cells, 8, 6)."""
    inverse_metric: Array
    """C^-1 at the Gauss points, shape (cells, 8, 6)."""
    corners_mm: Array
    """Natural places Z of the corners of each cell about its centre, shape (branches, cells, 8, 3) [mm]."""
    pulled_mm: Array
    """Places Y of the corners pulled back by the mean deformation, shape (cells, 8, 3) [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Relaxation:
    """A lattice with branches; every step starts from a `RelaxationState` and a step's length."""

    elasticity: Elasticity
    """The long-term lattice."""
    branches: Branches
    excess: Array
    """H: the springs of unit modulus less the network by the Gauss rule, shape (cells, 8, 8) [mm]."""
    gradients: Array
    """G: mean gradients of the corners' shape functions, shape (cells, 8, 3) [1/mm]."""

    @classmethod
    def of(cls, elasticity: Elasticity, branches: Branches) -> Self:
        """Prepares a lattice."""
        modulus = elasticity.lattice.shear_modulus_mpa
        network = network_matrices(elasticity.inverse, elasticity.weights, modulus)
        shares = elasticity.weights / elasticity.volumes[:, None]
        return cls(
            elasticity=elasticity,
            branches=branches,
            excess=(elasticity.springs - network) / modulus[:, None, None],
            gradients=np.einsum("cq,cqpi->cpi", shares, GAUSS_GRADIENTS @ elasticity.inverse),
        )

    def rest(self) -> RelaxationState:
        """Branches that have been at rest for ever."""
        lattice, count = self.elasticity.lattice, len(self.branches.times_s)
        pulled = self._pulled(lattice.nodes_mm)
        return RelaxationState(
            tensors=np.tile(UNIT, (count, len(lattice.cells), 8, 1)),
            inverse_metric=np.tile(UNIT, (len(lattice.cells), 8, 1)),
            corners_mm=np.tile(pulled, (count, 1, 1, 1)),
            pulled_mm=pulled,
        )

    def timed_elasticity(self, state: RelaxationState, *, dt_s: float) -> Elasticity:
        """The energy whose equilibrium is the lattice at the end of a time step from a state.

        Its gradient is the whole force, long-term and branches; its energy is an incremental potential and not what is
        stored. A step of 0 is a sudden change, an infinite one the long-term response [s].

        Raises:
            ConfigError: The step is negative.
        """
        elasticity, moduli = self.elasticity, self.branches.shear_modulus_mpa
        decay, start, mean = _weights(self.branches, dt_s)
        network = np.einsum("bc,bcqk->cqk", decay[:, None] * moduli, state.tensors)
        network += (start @ moduli)[:, None, None] * state.inverse_metric
        added = network_matrices(elasticity.inverse, elasticity.weights, network[:, :, FULL])
        return replace(
            elasticity,
            springs=elasticity.springs + added + self._excess_matrices(state, decay, start, mean),
            log_modulus_mpa=elasticity.log_modulus_mpa + mean @ moduli,
        )

    def advanced(self, state: RelaxationState, positions: Array, *, dt_s: float) -> RelaxationState:
        """The branches at the end of a time step whose equilibrium is known.

        Raises:
            ConfigError: The step is negative.
        """
        decay, start, mean = _weights(self.branches, dt_s)
        metric, pulled = _inverse_metric(self.elasticity, positions), self._pulled(positions)
        tensors = decay[:, None, None, None] * state.tensors
        corners = decay[:, None, None, None] * state.corners_mm
        for branch, (first, last) in enumerate(zip(start, 1 - mean, strict=True)):
            tensors[branch] += first * state.inverse_metric + last * metric
            corners[branch] += first * state.pulled_mm + last * pulled
        return RelaxationState(tensors=tensors, inverse_metric=metric, corners_mm=corners, pulled_mm=pulled)

    def _pulled(self, positions: Array) -> Array:
        """Corners about their centre, pulled back by the mean deformation gradient, shape (cells, 8, 3) [mm]."""
        corners = positions[self.elasticity.lattice.cells]
        corners = corners - corners.mean(1, keepdims=True)
        mean = corners.transpose(0, 2, 1) @ self.gradients
        return np.asarray(corners @ np.linalg.inv(mean).transpose(0, 2, 1))

    def _excess_matrices(self, state: RelaxationState, decay: Array, start: Array, mean: Array) -> Array:
        """Sum over the branches of mu m S^T H S, shape (cells, 8, 8) [N/mm], multiplied out."""
        moduli, g = self.branches.shear_modulus_mpa, self.gradients
        known = decay[:, None, None, None] * state.corners_mm + start[:, None, None, None] * state.pulled_mm
        forces = self.excess @ known
        once = g @ np.einsum("bc,bcpi->cip", moduli, forces)
        over_mean = np.divide(moduli, mean[:, None], out=np.zeros_like(moduli), where=mean[:, None] > 0)
        twice = np.einsum("bc,bcpi,bcpj->cij", over_mean, known, forces, optimize=True)
        whole = (mean @ moduli)[:, None, None] * self.excess
        return np.asarray(whole - once - once.transpose(0, 2, 1) + g @ twice @ g.transpose(0, 2, 1))


def body_branches(design: ElastomerDesign, lattice: Lattice) -> Branches:
    """The branches of a design for a timed path; `ConfigError` without a Prony series that its bulk modulus allows."""
    body = design.materials.body
    if not body.prony:
        msg = "materials.body.prony is missing: a timed path needs the relaxation of the body (time_s and modulus_mpa)"
        raise ConfigError(msg)
    bulk, shear = body.bulk_modulus_mpa, body.instantaneous_shear_modulus_mpa
    ratio = (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
    if ratio < LEAST_POISSON:
        least = 2 * shear * (1 + LEAST_POISSON) / (3 * (1 - 2 * LEAST_POISSON))
        needed = 0.5 - body.youngs_modulus_mpa / (6 * least)
        raise ConfigError(
            f"materials.body.poisson_ratio = {body.poisson_ratio:g} is not allowed on a timed path: its bulk modulus "
            f"of {bulk:.3g} MPa is too small for the instantaneous shear modulus of {shear:.3g} MPa; must be at least "
            f"{needed:.5f}"
        )
    return branch_moduli(design, lattice, [(term.time_s, term.modulus_mpa) for term in body.prony])


def branch_moduli(design: ElastomerDesign, lattice: Lattice, terms: Sequence[tuple[float, float]]) -> Branches:
    """The branches of a design whose body has a Prony series; the infill does not relax.

    Skin cells take mu = E / 2 (1 + nu) of each term. A core cell's stiffness is not proportional to that of its walls:
    the cell problem is solved with the walls' long-term and instantaneous stiffness (lambda the same), and the
    difference of the nearest isotropic shear modulus, C44 + 2/5 beta, goes to the branches in proportion to their E.
    Two things are left out. The effective modulus is not linear in that of the walls between the two: for Agilus30 in
    the default design branches in between come out up to 4 % too soft. And the structural springs of the walls keep
    their long-term beta; what beta gains comes back as its isotropic part alone, so at the instantaneous end such a
    core is isotropic: a quarter too soft when squeezed along its walls, a quarter too stiff in shear.

    Relaxation times are the caller's reading of the master curve: a time fitted against an axis in hertz is 2 pi
    times as long when that axis is in radians per second.

    Terms are relaxation times [s] with Young's moduli beyond the long-term one [MPa].

    Raises:
        ConfigError: A time is not positive, or a modulus negative.
    """
    times, moduli = np.array(terms, float).reshape(-1, 2).T
    if not ((times > 0) & (moduli >= 0)).all():
        raise ConfigError(f"Prony terms {list(terms)} are not allowed: times must be above 0, moduli 0 or more")
    added = moduli / (2 * (1 + design.materials.body.poisson_ratio))
    cells = np.tile(added[:, None], (1, len(lattice.cells)))
    slow, fast = (printed_fields(design, lattice.grid, added_mpa=each) for each in (0.0, float(added.sum())))
    if slow is not None and fast is not None and moduli.sum() > 0:
        change = fast.stiffness.isotropic_modulus_mpa - slow.stiffness.isotropic_modulus_mpa
        cells[:, lattice.is_core] = (change * moduli / moduli.sum())[:, None]
    return Branches(times_s=times, shear_modulus_mpa=cells)


def _weights(branches: Branches, dt_s: float) -> tuple[Array, Array, Array]:
    """Weights e^-x of the tensor before a step and m - e^-x of the metric before it; m; each of shape (branches,)."""
    if not dt_s >= 0:
        raise ConfigError(f"dt_s = {dt_s:g} is not allowed: must be 0 or more")
    ratio = dt_s / branches.times_s
    decay = np.exp(-ratio)
    mean = np.divide(-np.expm1(-ratio), ratio, out=np.ones_like(ratio), where=ratio > 0)
    return decay, mean - decay, mean


def _inverse_metric(elasticity: Elasticity, positions: Array) -> Array:
    """C^-1 at the Gauss points, cof(F)^T cof(F) / J^2, shape (cells, 8, 6)."""
    f = deformation_gradients(positions, elasticity.lattice.cells, elasticity.inverse)
    cofactor = np.stack([np.cross(f[:, :, row - 2], f[:, :, row - 1]) for row in range(3)], 2)
    jacobian = np.einsum("cqk,cqk->cq", f[:, :, 0], cofactor[:, :, 0])
    product = np.einsum("cqik,cqik->cqk", cofactor[..., ROWS], cofactor[..., COLUMNS])
    return np.asarray(product / (jacobian * jacobian)[:, :, None])
