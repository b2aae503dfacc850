"""The coat of the contact face as an elastic membrane: it resists stretch in its plane, and nothing else.

An incompressible neo-Hookean sheet in plane stress (Green and Adkins 1960, chapter 4; Treloar 1975) of thickness h and
shear modulus mu_c = E_c / 3 is bonded to the face. With C the metric of the deformed face in directions that are
orthonormal on the face at rest, and l1, l2 its principal stretches, each area at rest stores

    h mu_c / 2 (l1^2 + l2^2 + 1 / (l1 l2)^2 - 3) = h mu_c / 2 (tr C + 1 / det C - 3).

The first part is a network of springs without rest length, as the lattice has, and the second holds it open. The rest
shape, curved or not, is that of the lattice and free of stress. Each facet of the face is bilinear in its four nodes,
integrated at 2 x 2 Gauss points. Below det C = 1e-4 the second part goes on as a parabola, finite for trial states.

Bending is left out (`magicsim.geometry.coat` says where that holds), as are the height that a coat adds to the block,
and relaxation: the sheet is elastic on timed paths too.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.hexahedron import GAUSS_POINTS, shape_gradients
from magicsim.deform.lattice.pattern import BlockPattern
from magicsim.deform.lattice.structure import Lattice

SLOPES = shape_gradients(GAUSS_POINTS[:4] * [1, 1, 0])[:, :4, :2].transpose(0, 2, 1)
"""Derivatives of a facet's four shape functions at its Gauss points, shape (4 points, 2 directions, 4 corners)."""
LEAST_SQUARE = 1e-4
"""Squared ratio of areas below which its inverse goes on as a parabola: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Membrane:
    """The sheet on the facets of a lattice's contact face."""

    facets: Index
    """Nodes of each facet in the order of `hexahedron.CORNERS`, shape (facets, 4)."""
    slopes: Array
    """Derivatives of the shape functions along two directions that are orthonormal at rest, at the Gauss points, shape
    (facets, 4 points, 2 directions, 4 corners) [1/mm]."""
    weights: Array
    """h mu_c times the rest area of each Gauss point, shape (facets, 4) [N mm]."""

    @classmethod
    def on(cls, lattice: Lattice) -> Self | None:
        """The sheet on a lattice at rest; None where its face has none."""
        if lattice.coat_n_per_mm == 0:
            return None
        x, y = lattice.planes_mm[:2]
        facets = lattice.cells[: (len(x) - 1) * (len(y) - 1), :4]
        tangents = SLOPES @ lattice.nodes_mm[facets][:, None]
        root = np.linalg.cholesky(tangents @ tangents.transpose(0, 1, 3, 2))
        return cls(
            facets=facets,
            slopes=np.linalg.solve(root, np.broadcast_to(SLOPES, (len(facets), *SLOPES.shape))),
            weights=lattice.coat_n_per_mm * root[..., 0, 0] * root[..., 1, 1] / len(SLOPES),
        )

    def evaluate(self, positions: Array, gradient: Array) -> float:
        """Energy at node positions, shape (nodes, 3), zero at rest [N mm]; its gradient [N] is added in place."""
        tangents = self.slopes @ positions[self.facets][:, None]
        trace, square, half = _invariants(tangents)
        value, first, _ = _inverse(square)
        stress = self.weights[..., None, None] * (tangents + first[..., None, None] * half)
        np.add.at(gradient, self.facets, (self.slopes.transpose(0, 1, 3, 2) @ stress).sum(1))
        return float((self.weights * (trace + value - 3)).sum() / 2)

    def add_stiffness(self, positions: Array, pattern: BlockPattern, values: Array, *, shift: float) -> None:
        """Adds the Hessian to an upper triangle in 3 x 3 blocks, in place."""
        tangents = self.slopes @ positions[self.facets][:, None]
        _, square, half = _invariants(tangents)
        _, first, second = _inverse(square)
        own = np.einsum("fqai,fqbj->fqaibj", half, half) * (2 * second)[..., None, None, None, None]
        own += first[..., None, None, None, None] * _curvature(tangents)
        own += (1 + shift) * np.einsum("ab,ij->aibj", np.eye(2), np.eye(3))
        own *= self.weights[..., None, None, None, None]
        right = np.einsum("fqaibj,fqbr->fqaijr", own, self.slopes)
        stiffness = np.einsum("fqap,fqaijr->fprij", self.slopes, right)
        for p in range(4):
            for r in range(p, 4):
                start = 3 * pattern.blocks[: len(self.facets), p, r]
                for i in range(3):
                    row = pattern.indptr[3 * self.facets[:, p] + i] + start - i
                    for k in range(i if p == r else 0, 3):
                        np.add.at(values, row + k, stiffness[:, p, r, i, k])


def _invariants(tangents: Array) -> tuple[Array, Array, Array]:
    """Trace and determinant of C, and half the latter's gradient by the tangents, which are of shape (..., 2, 3)."""
    metric = tangents @ tangents.swapaxes(-1, -2)
    cofactor = metric[..., ::-1, ::-1] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    trace = metric[..., 0, 0] + metric[..., 1, 1]
    return trace, metric[..., 0, 0] * metric[..., 1, 1] - metric[..., 0, 1] ** 2, cofactor @ tangents


def _curvature(tangents: Array) -> Array:
    """Half the second derivative of det C by the tangents, shape (..., 2, 3, 2, 3)."""
    one, other = tangents[..., 0, :], tangents[..., 1, :]
    curvature = np.empty((*tangents.shape, *tangents.shape[-2:]))
    mixed = 2 * one[..., :, None] * other[..., None, :] - other[..., :, None] * one[..., None, :]
    mixed -= (one * other).sum(-1)[..., None, None] * np.eye(3)
    curvature[..., 0, :, 1, :], curvature[..., 1, :, 0, :] = mixed, mixed.swapaxes(-1, -2)
    for axis, along in ((0, other), (1, one)):
        length = (along * along).sum(-1)[..., None, None]
        curvature[..., axis, :, axis, :] = length * np.eye(3) - along[..., :, None] * along[..., None, :]
    return curvature


def _inverse(square: Array) -> tuple[Array, Array, Array]:
    """1 / s, twice continuously differentiable for any s: value, first and second derivative."""
    bounded = np.maximum(square, LEAST_SQUARE)
    below = square - bounded
    value, first, second = 1 / bounded, -1 / bounded**2, 2 / bounded**3
    return value + first * below + second / 2 * below**2, first + second * below, second
