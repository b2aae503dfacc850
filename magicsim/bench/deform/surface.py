"""Displacement anywhere on the contact face from a method's nodes there."""

import numpy as np
from scipy.interpolate import RectBivariateSpline

from magicsim.arrays import Array

ROUNDING_MM = 1e-9
"""Slack of a plane's place [mm]."""


def displacement_at(points_mm: Array, x_mm: Array, y_mm: Array, values_mm: Array) -> Array:
    """Displacement at points of the undeformed face, from cubic splines through the nodes.

    Args:
        points_mm: Positions at rest, shape (points, 3) [mm].
        x_mm: Node planes along x, increasing [mm]; planes that begin at 0 belong to a quarter of the block, and its
            mirror images make the splines smooth across the planes of symmetry.
        y_mm: The same along y [mm].
        values_mm: Displacements of the nodes, shape (len(y_mm), len(x_mm), 3) [mm].

    Returns:
        Displacements, shape (points, 3) [mm].
    """
    if x_mm[0] > -ROUNDING_MM:
        values_mm = np.concatenate([values_mm[:, :0:-1] * [-1, 1, 1], values_mm], 1)
        values_mm = np.concatenate([values_mm[:0:-1] * [1, -1, 1], values_mm], 0)
        x_mm, y_mm = (np.concatenate([-axis[:0:-1], axis]) for axis in (x_mm, y_mm))
    degree_y, degree_x = min(3, len(y_mm) - 1), min(3, len(x_mm) - 1)
    splines = (RectBivariateSpline(y_mm, x_mm, values_mm[:, :, axis], kx=degree_y, ky=degree_x) for axis in range(3))
    return np.stack([spline.ev(points_mm[:, 1], points_mm[:, 0]) for spline in splines], 1)
