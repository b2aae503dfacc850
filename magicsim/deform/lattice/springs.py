"""Spring weights of a box cell: zero-rest-length springs whose affine energy is exactly mu/2 V tr(F^T F).

The springs are Gaussian chains (James and Guth's phantom network). A cell of edges a x b x c holds a quarter of
each of its twelve edge springs, half of each of its twelve face diagonals and its four body diagonals. Affine
motion F stretches a spring of rest vector d to F d, so the energy is exact when, along x and cyclically,

    k_x a^2 + 2 (k_xy + k_xz) a^2 + 4 k_body a^2 = mu V.

Given the diagonals, the edges follow. The share `FACE_SHARE` of mu V / max(a, b, c)^2 for the faces and
`BODY_SHARE` for the body keep every spring non-negative as long as 4 FACE_SHARE + 4 BODY_SHARE <= 1. Under
refinement the topology is a quadrature rule only: all choices have the same limit.
"""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.lattice.hexahedron import CORNERS, GAUSS_GRADIENTS

FACE_SHARE = 0.1
"""Stiffness of a face diagonal in units of mu V / max(a, b, c)^2."""
BODY_SHARE = 0.0
"""Stiffness of a body diagonal in the same units."""


def spring_stiffness(sizes_mm: Array, shear_modulus_mpa: Array) -> tuple[Array, Array, Array]:
    """Stiffness of the springs of box cells, each as if it were shared by no missing neighbour.

    Args:
        sizes_mm: Cell edges, shape (cells, 3) [mm].
        shear_modulus_mpa: Shear modulus, shape (cells,) [MPa].

    Returns:
        Edge springs along x, y, z, shape (cells, 3); face diagonals, shape (cells,); body diagonals,
        shape (cells,) [N/mm]; all non-negative.
    """
    energy = shear_modulus_mpa * sizes_mm.prod(1)
    unit = energy / sizes_mm.max(1) ** 2
    face, body = FACE_SHARE * unit, BODY_SHARE * unit
    edges = energy[:, None] / sizes_mm**2 - 4 * face[:, None] - 4 * body[:, None]
    return edges, face, body


def spring_matrices(sizes_mm: Array, shear_modulus_mpa: Array) -> Array:
    """Graph Laplacian of each cell's own share of its springs.

    Args:
        sizes_mm: Cell edges, shape (cells, 3) [mm].
        shear_modulus_mpa: Shear modulus, shape (cells,) [MPa].

    Returns:
        Matrices, shape (cells, 8, 8) [N/mm]; the spring energy of a cell is x^T L x / 2 for each coordinate.
    """
    edges, face, body = spring_stiffness(sizes_mm, shear_modulus_mpa)
    laplacian = np.zeros((len(sizes_mm), 8, 8))
    for p in range(8):
        for q in range(p):
            axes = np.flatnonzero(CORNERS[p] != CORNERS[q])
            share = {1: edges[:, axes[0]] / 4, 2: face / 2, 3: body}[len(axes)]
            laplacian[:, p, p] += share
            laplacian[:, q, q] += share
            laplacian[:, p, q] -= share
            laplacian[:, q, p] -= share
    return laplacian


def network_matrices(inverse: Array, volumes: Array, modulus_mpa: Array) -> Array:
    """Graph Laplacian of a Gaussian network in cells of any shape, by their Gauss points.

    The entries -sum_q V_q grad N_p . M_q grad N_r are springs that may push (negative ones in distorted cells), but
    the matrix stays positive semi-definite and an affine motion is in exact equilibrium.

    Args:
        inverse: From `gauss_geometry`, shape (cells, 8, 3, 3) [1/mm].
        volumes: From `gauss_geometry`, shape (cells, 8) [mm3].
        modulus_mpa: Network tensor M, shape (cells, 8, 3, 3), or its isotropic value, shape (cells,) [MPa].

    Returns:
        Matrices, shape (cells, 8, 8) [N/mm].
    """
    gradients = GAUSS_GRADIENTS @ inverse
    if modulus_mpa.ndim == 1:
        weighted = gradients * (modulus_mpa[:, None] * volumes)[:, :, None, None]
    else:
        weighted = gradients @ (modulus_mpa * volumes[:, :, None, None])
    left, right = (each.transpose(0, 1, 3, 2).reshape(len(inverse), 24, 8) for each in (weighted, gradients))
    return np.asarray(left.transpose(0, 2, 1) @ right)
