"""The trilinear hexahedron on the unit cube: corner order, shape functions and Gauss points.

Corners are numbered with x fastest and z slowest, so the first four lie on the low-z face and local order agrees with
the lattice's global node order.
"""

import numpy as np

from magicsim.arrays import Array

CORNERS = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)])
"""Corner coordinates on the unit cube, shape (8, 3)."""


def shape_values(points: Array) -> Array:
    """Trilinear shape functions.

    Args:
        points: Positions on the unit cube, shape (count, 3).

    Returns:
        Values, shape (count, 8); each row sums to 1.
    """
    factors = np.where(CORNERS[None] == 1, points[:, None], 1 - points[:, None])
    return np.asarray(factors.prod(-1))


def shape_gradients(points: Array) -> Array:
    """Gradients of the shape functions with respect to the unit cube's coordinates.

    Args:
        points: Positions on the unit cube, shape (count, 3).

    Returns:
        Gradients, shape (count, 8, 3).
    """
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
    """How cells of any shape map from the unit cube, at the Gauss points.

    Args:
        corners_mm: Rest positions of the corners, shape (cells, 8, 3) [mm].

    Returns:
        Inverse of the map's Jacobian, shape (cells, 8 points, 3, 3) [1/mm]: a gradient on the unit cube times it is
        the gradient at rest; and the volume of each point, shape (cells, 8) [mm3].
    """
    jacobian = np.einsum("cpi,qpk->cqik", corners_mm, GAUSS_GRADIENTS, optimize=True)
    return np.linalg.inv(jacobian), np.linalg.det(jacobian) / 8
