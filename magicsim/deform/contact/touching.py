"""Which contact points touch the object, where the face waves between its nodes.

Below a flat face, and beside its edges, a lattice cannot lie flat: it is pressed at some of its points and is apart by
hundredths of a millimetre between them, the less the finer it is. What is that near, with points that touch all around
it, touches. Beside a round object nothing touches beyond the border of the contact, and nothing is bridged there.
"""

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Mask
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.lattice.structure import Lattice

WAVE_MM = 0.02
"""Gap up to which a face waves below flat objects [mm]: measured at the middle of a box on cells of 0.1 to 0.9 mm."""
ONE_SIDED = 0.5
"""Length of the mean direction to the points that touch around another, from which they lie to one side of it."""
LEAST_AROUND = 4
"""Fewest points around another."""


def touching_points(
    lattice: Lattice, face: ContactFace, points_mm: Array, gap_mm: Array, *, gap_limit_mm: float
) -> Mask:
    """Which points touch, shape (points,).

    Args:
        lattice: The block.
        face: Its contact points.
        points_mm: Where they are, shape (points, 3) [mm].
        gap_mm: Their distances to the object, shape (points,) [mm].
        gap_limit_mm: Gap up to which a point touches by itself [mm].
    """
    touching = gap_mm <= gap_limit_mm
    apart = np.flatnonzero(~touching & (gap_mm <= WAVE_MM))
    own = points_mm[touching, :2]
    if len(apart) == 0 or len(own) < LEAST_AROUND:
        return touching
    x, y = (np.diff(planes) for planes in lattice.planes_mm[:2])
    reach = np.maximum(x[face.facet[apart] % len(x)], y[face.facet[apart] // len(x)])
    around = cKDTree(own).query_ball_point(points_mm[apart, :2], reach)
    is_between = np.zeros(len(apart), bool)
    for number, near in enumerate(around):
        if len(near) >= LEAST_AROUND:
            ways = own[near] - points_mm[apart[number], :2]
            ways /= np.maximum(np.linalg.norm(ways, axis=1), 1e-12)[:, None]
            is_between[number] = np.linalg.norm(ways.mean(0)) < ONE_SIDED
    touching[apart[is_between]] = True
    return touching
