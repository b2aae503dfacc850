"""Energy, gradient and Hessian of the lattice: numba kernels over its cells.

    W = sum_springs k/2 |x_i - x_j|^2 - sum_cells mu V0 <ln J> + sum_cells lambda/2 V0 (Jbar - 1)^2 + walls

The network springs have no rest length (the structural springs of printed walls, in `walls`, have one). J is the
Jacobian at the 2 x 2 x 2 Gauss points and Jbar their mean, which is the exact trilinear volume over V0 (the Jacobian is
quadratic in each coordinate, so two points a direction integrate it). The pressure term is no stabiliser: a Gaussian
network alone has no elastic constants and would collapse. For affine motion and no walls W is the compressible neo-
Hookean solid mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2 (Bonet and Wood 2008, 6.4.3, with that volume term). Below
J = 0.01 the logarithm goes on as a parabola with the same value, slope and curvature, so that W stays finite for trial
states.
"""

# ruff: noqa: ANN001, ANN202 -- numba infers the types of the kernels.

from dataclasses import dataclass

import numba as nb
import numpy as np
import numpy.typing as npt

from magicsim.deform.hexahedron import CORNERS, EDGES, GAUSS_GRADIENTS, gauss_geometry
from magicsim.deform.lattice import Lattice
from magicsim.deform.pattern import BlockPattern
from magicsim.deform.springs import network_matrices, spring_matrices
from magicsim.deform.table import Table, TableState
from magicsim.deform.walls import add_wall_stiffness, add_walls

Array = npt.NDArray[np.float64]
LOG_LIMIT = 0.01
"""Jacobian below which -ln J is continued as a parabola."""
TINY = 1e-300
BOX_SLACK_MM = 1e-9
"""Largest deviation of a corner in a cell that counts as a box [mm]."""
SLENDER = 1.5
"""Ratio of edges from which a box takes its springs from the Gauss points: edge and face springs of long cells are too
stiff, which costs a graded lattice two thirds of its accuracy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ElasticState:
    """What the lattice's energy is at given positions."""

    energy_mj: float
    """Springs, logarithm, walls and table, without the volume term, zero at rest [N mm]."""
    gradient: Array
    """Of the whole energy, the volume term included, shape (nodes, 3) [N]."""
    jacobian: Array
    """Volume over rest volume of each cell, shape (cells,)."""
    volume_gradient: Array
    """Of each cell's volume, shape (cells, 24) [mm2]."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    table: TableState | None
    """What the table does to the base; None where it is bonded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elasticity:
    """The lattice as the kernels want it."""

    lattice: Lattice
    volumes: Array
    """Rest volume of each cell, shape (cells,) [mm3]."""
    inverse: Array
    """Inverse Jacobian of the rest map at the Gauss points, shape (cells, 8, 3, 3) [1/mm]."""
    weights: Array
    """Rest volume of each Gauss point, shape (cells, 8) [mm3]."""
    springs: Array
    """Laplacian of the network springs, shape (cells, 8, 8) [N/mm]."""
    log_modulus_mpa: Array
    """Factor of -ln J: the shear modulus, shape (cells,) [MPa]."""
    walls: Array
    """Stiffness beta V / 4 of the structural springs of each cell, shape (cells,) [N mm]."""
    wall_ratio: Array
    """mu / 2 beta of each cell, see `walls`, shape (cells,)."""
    edges_mm: Array
    """Rest length of the edges, shape (cells, 12) [mm]."""
    table: Table | None = None
    """What the base lies on; None where it is bonded."""

    @classmethod
    def of(cls, lattice: Lattice) -> "Elasticity":
        """Prepares a lattice."""
        corners = lattice.nodes_mm[lattice.cells]
        inverse, weights = gauss_geometry(corners)
        springs = spring_matrices(lattice.sizes_mm, lattice.shear_modulus_mpa)
        bent = ~_have_spring_weights(corners, lattice.sizes_mm)
        springs[bent] = network_matrices(inverse[bent], weights[bent], lattice.shear_modulus_mpa[bent])
        volumes = weights.sum(1)
        return cls(
            lattice=lattice,
            volumes=volumes,
            inverse=inverse,
            weights=weights,
            springs=springs,
            log_modulus_mpa=lattice.shear_modulus_mpa,
            walls=lattice.wall_modulus_mpa * volumes / 4,
            wall_ratio=lattice.shear_modulus_mpa / np.maximum(2 * lattice.wall_modulus_mpa, TINY),
            edges_mm=np.linalg.norm(corners[:, EDGES[:, 1]] - corners[:, EDGES[:, 0]], axis=2),
            table=Table.below(lattice),
        )

    def evaluate(self, positions: Array) -> ElasticState:
        """Energy, gradient and Jacobians.

        Args:
            positions: Node positions, shape (nodes, 3) [mm].
        """
        lattice = self.lattice
        count = len(lattice.cells)
        energy, jacobian, volume_gradient = np.empty(count), np.empty(count), np.empty((count, 24))
        gradient = np.zeros_like(positions)
        smallest = _evaluate(
            positions, lattice.cells, GAUSS_GRADIENTS, EDGES, self.inverse, self.weights, self.log_modulus_mpa,
            lattice.lame_mpa, self.springs, self.walls, self.wall_ratio, self.edges_mm,
            energy, jacobian, volume_gradient, gradient,
        )  # fmt: skip
        below = None
        if self.table is not None:
            below = self.table.evaluate(positions)
            gradient[self.table.first :] -= below.node_force_n
        return ElasticState(
            energy_mj=float(energy.sum()) + (below.energy_mj if below is not None else 0.0),
            gradient=gradient,
            jacobian=jacobian,
            volume_gradient=volume_gradient,
            min_jacobian=float(smallest),
            table=below,
        )

    def hessian(
        self, positions: Array, pressure: Array, volume_gradient: Array, pattern: BlockPattern, *, shift: float
    ) -> Array:
        """Upper triangle of the Hessian of the free nodes, with the pressure as an independent unknown condensed out.

        Args:
            positions: Node positions, shape (nodes, 3) [mm].
            pressure: Volumetric stress of each cell, lambda (Jbar - 1) when converged, shape (cells,) [MPa].
            volume_gradient: From `evaluate`, shape (cells, 24).
            pattern: Where the entries go.
            shift: Multiple of the spring Laplacian that is added.

        Returns:
            Entries in the pattern's order, shape (pattern.entries,) [N/mm].
        """
        lattice = self.lattice
        values = np.zeros(pattern.entries)
        _fill_hessian(
            positions, lattice.cells, GAUSS_GRADIENTS, EDGES, self.inverse, self.weights, self.log_modulus_mpa,
            lattice.lame_mpa / self.volumes, pressure, self.springs * (1 + shift), self.walls, self.wall_ratio,
            self.edges_mm, volume_gradient, pattern.indptr, pattern.blocks, values,
        )  # fmt: skip
        if self.table is not None:
            self.table.add_stiffness(positions, pattern.indptr, values)
        return values


def _have_spring_weights(corners_mm: Array, sizes_mm: Array) -> npt.NDArray[np.bool_]:
    """Whether cells are boxes along the axes that are not too long for the weights of `springs`, shape (cells,)."""
    offset = corners_mm - corners_mm[:, :1] - CORNERS * sizes_mm[:, None]
    is_box = (np.abs(offset) < BOX_SLACK_MM).all((1, 2))
    return np.asarray(is_box & (sizes_mm.max(1) < SLENDER * sizes_mm.min(1)))


@nb.njit(cache=True, error_model="numpy")
def negative_log(jacobian: float) -> tuple[float, float, float]:
    """-ln J, twice continuously differentiable down to any J: value, first and second derivative."""
    if jacobian > LOG_LIMIT:
        return -np.log(jacobian), -1 / jacobian, 1 / (jacobian * jacobian)
    if np.isnan(jacobian):
        return np.nan, np.nan, np.nan
    d = jacobian - LOG_LIMIT
    slope, curvature = 1 / LOG_LIMIT, 1 / LOG_LIMIT**2
    return -np.log(LOG_LIMIT) - slope * d + curvature / 2 * d * d, -slope + curvature * d, curvature


@nb.njit(cache=True, error_model="numpy")
def _deformation(x, nodes, gauss, inverse, dn, f, cof):  # type: ignore[no-untyped-def]
    """Rest gradients, deformation gradient and its cofactor at one Gauss point, in place; returns the Jacobian."""
    for p in range(8):
        for k in range(3):
            dn[p, k] = gauss[p, 0] * inverse[0, k] + gauss[p, 1] * inverse[1, k] + gauss[p, 2] * inverse[2, k]
    for i in range(3):
        for k in range(3):
            total = 0.0
            for p in range(8):
                total += x[nodes[p], i] * dn[p, k]
            f[i, k] = total
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for k in range(3):
            c, d = (k + 1) % 3, (k + 2) % 3
            cof[i, k] = f[a, c] * f[b, d] - f[a, d] * f[b, c]
    return f[0, 0] * cof[0, 0] + f[0, 1] * cof[0, 1] + f[0, 2] * cof[0, 2]


@nb.njit(cache=True, error_model="numpy")
def _evaluate(  # type: ignore[no-untyped-def]
    x, cells, gauss, edges, inverse, weights, mu, lame, springs, walls, rho, lengths, energy, jacobian, volume_gradient,
    gradient,
):  # fmt: skip
    smallest = np.inf
    f, cof, own, dn = np.empty((3, 3)), np.empty((3, 3)), np.empty((8, 3)), np.empty((8, 3))
    for c in range(cells.shape[0]):
        nodes = cells[c]
        volume_gradient[c] = 0.0
        mean, total, volume = 0.0, 0.0, 0.0
        for p in range(8):
            for i in range(3):
                force = 0.0
                for r in range(8):
                    force += springs[c, p, r] * x[nodes[r], i]
                own[p, i] = force
                total += 0.5 * force * x[nodes[p], i]
        for q in range(8):
            j = _deformation(x, nodes, gauss[q], inverse[c, q], dn, f, cof)
            if not j >= smallest:
                smallest = j
            value, first, _ = negative_log(j)
            weight = weights[c, q]
            volume += weight
            mean += j * weight
            total += mu[c] * weight * (value - 1.5)
            for p in range(8):
                for i in range(3):
                    g = cof[i, 0] * dn[p, 0] + cof[i, 1] * dn[p, 1] + cof[i, 2] * dn[p, 2]
                    own[p, i] += mu[c] * weight * first * g
                    volume_gradient[c, 3 * p + i] += weight * g
        if walls[c] > 0:
            total += add_walls(x, nodes, edges, lengths[c], walls[c], rho[c], own)
        energy[c], jacobian[c] = total, mean / volume
        pressure = lame[c] * (mean / volume - 1)
        for p in range(8):
            for i in range(3):
                gradient[nodes[p], i] += own[p, i] + pressure * volume_gradient[c, 3 * p + i]
    return smallest


@nb.njit(cache=True, error_model="numpy")
def _fill_hessian(  # type: ignore[no-untyped-def]  # noqa: PLR0912
    x, cells, gauss, edges, inverse, weights, mu, stiffness, pressure, springs, walls, rho, lengths, volume_gradient,
    indptr, blocks, values,
):  # fmt: skip
    f, cof, m = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    g, own, dn = np.empty(24), np.empty((24, 24)), np.empty((8, 3))
    for c in range(cells.shape[0]):
        nodes = cells[c]
        for a in range(24):
            for b in range(24):
                own[a, b] = stiffness[c] * volume_gradient[c, a] * volume_gradient[c, b]
        for p in range(8):
            for r in range(8):
                for i in range(3):
                    own[3 * p + i, 3 * r + i] += springs[c, p, r]
        if walls[c] > 0:
            add_wall_stiffness(x, nodes, edges, lengths[c], walls[c], rho[c], own)
        for q in range(8):
            weight = weights[c, q]
            j = _deformation(x, nodes, gauss[q], inverse[c, q], dn, f, cof)
            _, first, second = negative_log(j)
            for p in range(8):
                for i in range(3):
                    g[3 * p + i] = cof[i, 0] * dn[p, 0] + cof[i, 1] * dn[p, 1] + cof[i, 2] * dn[p, 2]
            outer, geometric = mu[c] * second * weight, (mu[c] * first + pressure[c]) * weight
            for p in range(8):
                for r in range(p, 8):
                    c0 = dn[p, 1] * dn[r, 2] - dn[p, 2] * dn[r, 1]
                    c1 = dn[p, 2] * dn[r, 0] - dn[p, 0] * dn[r, 2]
                    c2 = dn[p, 0] * dn[r, 1] - dn[p, 1] * dn[r, 0]
                    for i in range(3):
                        m[i] = geometric * (f[i, 0] * c0 + f[i, 1] * c1 + f[i, 2] * c2)
                    for i in range(3):
                        for k in range(3):
                            own[3 * p + i, 3 * r + k] += outer * g[3 * p + i] * g[3 * r + k]
                    own[3 * p, 3 * r + 1] += m[2]
                    own[3 * p + 1, 3 * r] -= m[2]
                    own[3 * p + 1, 3 * r + 2] += m[0]
                    own[3 * p + 2, 3 * r + 1] -= m[0]
                    own[3 * p + 2, 3 * r] += m[1]
                    own[3 * p, 3 * r + 2] -= m[1]
        for p in range(8):
            for r in range(p, 8):
                block = blocks[c, p, r]
                if block < 0:
                    continue
                for i in range(3):
                    start = indptr[3 * nodes[p] + i] + 3 * block - i
                    for k in range(i if p == r else 0, 3):
                        values[start + k] += own[3 * p + i, 3 * r + k]
