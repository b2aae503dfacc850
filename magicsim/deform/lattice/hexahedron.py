"""The trilinear hexahedron on the unit cube, and the springs without rest length that a cell of that shape holds.

Corners are numbered with x fastest and z slowest, so the first four lie on the low-z face and local order agrees with
the lattice's global node order.

**Springs** are Gaussian chains (James and Guth's phantom network). A cell of edges a x b x c holds a quarter of each of
its twelve edge springs and half of each of its twelve face diagonals; body diagonals have none. Given the diagonals the
edges follow: affine motion F stores mu/2 V tr(F^T F) when k_x a^2 + 2 (k_xy + k_xz) a^2 = mu V, along x and cyclically.
The share `FACE_SHARE` of mu V / max(a, b, c)^2 for the faces keeps every spring non-negative up to 1/4. Under
refinement the topology is a quadrature rule only: all choices have the same limit.
"""

import numpy as np

from magicsim.arrays import Array, Index

CORNERS = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)])
"""Corner coordinates on the unit cube, shape (8, 3)."""


def shape_values(points: Array) -> Array:
    """Trilinear shape functions at points of the unit cube, shape (count, 3): shape (count, 8), rows sum to 1."""
    factors = np.where(CORNERS[None] == 1, points[:, None], 1 - points[:, None])
    return np.asarray(factors.prod(-1))


def shape_gradients(points: Array) -> Array:
    """Gradients of the shape functions at points of the unit cube, shape (count, 3): shape (count, 8, 3)."""
    factors = np.where(CORNERS[None] == 1, points[:, None], 1 - points[:, None])
    signs = 2.0 * CORNERS - 1
    gradients = np.empty((len(points), 8, 3))
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        gradients[:, :, axis] = signs[:, axis] * factors[:, :, others].prod(-1)
    return gradients


_ABSCISSAE = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
GAUSS_POINTS = _ABSCISSAE[CORNERS]
"""The 2 x 2 x 2 Gauss points on the unit cube, shape (8, 3); every weight is 1/8."""
GAUSS_GRADIENTS = shape_gradients(GAUSS_POINTS)
"""Shape function gradients at the Gauss points, shape (8 points, 8 corners, 3)."""
EDGES = np.array([[p, r] for p in range(8) for r in range(p + 1, 8) if abs(CORNERS[p] - CORNERS[r]).sum() == 1])
"""Corners of the twelve edges, shape (12, 2)."""
CORNERS_ALONG = np.array([[p for p in range(8) if CORNERS[p, axis] == 0] for axis in range(3)])
"""Corners where the four edges along each axis begin, shape (3, 4)."""
NEXT_CORNER = np.array([1, 2, 4])
"""From there to where they end."""
_SHARES = np.stack([1 - _ABSCISSAE, _ABSCISSAE])
MEAN_OF_EDGES = np.array([[_SHARES[m % 2, s % 2] * _SHARES[m // 2, s // 2] for m in range(4)] for s in range(4)])
"""Weights of four parallel edges, shape (4 rows of Gauss points along them, 4 edges)."""
GAUSS_COLUMNS = np.array([[q // 2, q % 2 + 2 * (q // 4), q % 4] for q in range(8)])
"""Row of each Gauss point along each axis, shape (8, 3)."""


def gauss_geometry(corners_mm: Array) -> tuple[Array, Array]:
    """How cells of any shape, rest corners of shape (cells, 8, 3) [mm], map from the unit cube, at the Gauss points.

    Inverse of the map's Jacobian, shape (cells, 8 points, 3, 3) [1/mm]: a gradient on the unit cube times it is the
    gradient at rest; and the volume of each point, shape (cells, 8) [mm3].
    """
    jacobian = np.einsum("cpi,qpk->cqik", corners_mm, GAUSS_GRADIENTS, optimize=True)
    return np.linalg.inv(jacobian), np.linalg.det(jacobian) / 8


def deformation_gradients(positions: Array, cells: Index, inverse: Array) -> Array:
    """F at the Gauss points, shape (cells, 8, 3, 3), at positions of shape (nodes, 3) [mm]; see `gauss_geometry`."""
    corners = positions.T[:, cells].transpose(1, 0, 2)
    return np.asarray(corners[:, None] @ GAUSS_GRADIENTS @ inverse)


FACE_SHARE = 0.1
"""Stiffness of a face diagonal in units of mu V / max(a, b, c)^2: assumed, within what keeps edges from pushing."""


def spring_matrices(sizes_mm: Array, shear_modulus_mpa: Array) -> Array:
    """Graph Laplacian of each box cell's own share of its springs, none of them negative, shape (cells, 8, 8) [N/mm].

    The spring energy of a cell is x^T L x / 2 for each coordinate. Edges are of shape (cells, 3) [mm], shear moduli of
    shape (cells,) [MPa].
    """
    energy = shear_modulus_mpa * sizes_mm.prod(1)
    face = FACE_SHARE * (energy / sizes_mm.max(1) ** 2)
    edges = energy[:, None] / sizes_mm**2 - 4 * face[:, None]
    laplacian = np.zeros((len(sizes_mm), 8, 8))
    for p in range(8):
        for q in range(p):
            axes = np.flatnonzero(CORNERS[p] != CORNERS[q])
            if len(axes) == 3:  # noqa: PLR2004 -- a body diagonal, which has no spring
                continue
            share = edges[:, axes[0]] / 4 if len(axes) == 1 else face / 2
            laplacian[:, p, p] += share
            laplacian[:, q, q] += share
            laplacian[:, p, q] -= share
            laplacian[:, q, p] -= share
    return laplacian


def network_matrices(inverse: Array, volumes: Array, modulus_mpa: Array) -> Array:
    """Graph Laplacian of a Gaussian network in cells of any shape, shape (cells, 8, 8) [N/mm], by their Gauss points.

    The entries -sum_q V_q grad N_p . M_q grad N_r are springs that may push (negative ones in distorted cells), but
    the matrix stays positive semi-definite and an affine motion is in exact equilibrium. Inverse and volumes are those
    of `gauss_geometry`; M is of shape (cells, 8, 3, 3), or isotropic of shape (cells,) [MPa].
    """
    gradients = GAUSS_GRADIENTS @ inverse
    if modulus_mpa.ndim == 1:
        weighted = gradients * (modulus_mpa[:, None] * volumes)[:, :, None, None]
    else:
        weighted = gradients @ (modulus_mpa * volumes[:, :, None, None])
    left, right = (each.transpose(0, 1, 3, 2).reshape(len(inverse), 24, 8) for each in (weighted, gradients))
    return np.asarray(left.transpose(0, 2, 1) @ right)
