"""Which contact points touch the object, where the face waves between its nodes or cannot follow a contact's border.

Below a flat face, and beside its edges, a lattice cannot lie flat: it is pressed at some of its points and is apart by
hundredths of a millimetre between them, the less the finer it is. What is that near, with points that touch all around
it, touches. At the border of a contact with a round object the face leaves it at a tangent, which nodes h apart show no
better than by h^2 / 8R, the height of an arc over its chord: what is nearer than three quarters of that touches.
"""

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Index, Mask
from magicsim.deform.contact.face import ContactFace
from magicsim.deform.lattice.structure import Lattice

WAVE_MM = 0.02
"""Gap up to which a face waves below flat objects [mm]: measured at the middle of a box on cells of 0.1 to 0.9 mm."""
ONE_SIDED = 0.5
"""Length of the mean direction to the points that touch around another, from which they lie to one side of it:
assumed."""
LEAST_AROUND = 4
"""Fewest points around another: assumed."""
BORDER = 0.75
"""Share of an arc's height over its chord up to which a border's points touch: measured on balls of 2, 4 and 8 mm
radius, 0.05 to 1.5 mm deep, on cells of 0.3 to 0.9 mm, against cells of 0.25 mm."""
SMOOTH_RAD = 0.46
"""Turn of an object's normal over a facet above which it has an edge or a texture there, and no radius; that of a ball
of 2 mm over a cell of 0.9 mm is 0.45."""


def border_gaps_mm(lattice: Lattice, face: ContactFace, points_mm: Array, normals: Array) -> Array:
    """Gap up to which each point touches beside a round object, shape (points,) [mm]; 0 where that has no radius.

    Args:
        lattice: The block.
        face: Its contact points, ordered by facet.
        points_mm: Where they are, shape (points, 3) [mm].
        normals: Of the object's surface next to them, shape (points, 3).
    """
    first = np.flatnonzero(np.diff(face.facet, prepend=-1))
    count = np.diff(first, append=len(face.facet))
    edge = _edges_mm(lattice, face.facet[first])

    def spread(values: Array) -> Array:
        mean = np.add.reduceat(values, first) / count[:, None]
        return np.asarray(np.maximum.reduceat(np.linalg.norm(values - np.repeat(mean, count, 0), axis=1), first))

    turn = spread(normals) / np.maximum(spread(points_mm), 1e-12) * edge
    return np.repeat(np.where(turn <= SMOOTH_RAD, BORDER * turn * edge / 8, 0.0), count)


def touching_points(
    lattice: Lattice, face: ContactFace, points_mm: Array, gap_mm: Array, *, gap_limits_mm: Array | float
) -> Mask:
    """Which points touch, shape (points,).

    Args:
        lattice: The block.
        face: Its contact points.
        points_mm: Where they are, shape (points, 3) [mm].
        gap_mm: Their distances to the object, shape (points,) [mm].
        gap_limits_mm: Gap up to which a point touches by itself, one for all or shape (points,) [mm].
    """
    touching = gap_mm <= gap_limits_mm
    apart = np.flatnonzero(~touching & (gap_mm <= WAVE_MM))
    own = points_mm[touching, :2]
    if len(apart) == 0 or len(own) < LEAST_AROUND:
        return touching
    around = cKDTree(own).query_ball_point(points_mm[apart, :2], _edges_mm(lattice, face.facet[apart]))
    is_between = np.zeros(len(apart), bool)
    for number, near in enumerate(around):
        if len(near) >= LEAST_AROUND:
            directions = own[near] - points_mm[apart[number], :2]
            directions /= np.maximum(np.linalg.norm(directions, axis=1), 1e-12)[:, None]
            is_between[number] = np.linalg.norm(directions.mean(0)) < ONE_SIDED
    touching[apart[is_between]] = True
    return touching


def _edges_mm(lattice: Lattice, facets: Index) -> Array:
    """Longer edge of some facets at rest, of the shape of their numbers [mm]."""
    x, y = (np.diff(planes) for planes in lattice.planes_mm[:2])
    return np.asarray(np.maximum(x[facets % len(x)], y[facets // len(x)]))
