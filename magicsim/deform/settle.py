"""Fits the skin's surface to the object it touches: the lattice is coarser than the surface that is rendered.

Contact is solved at points, to a tolerance; between them, and between the vertices that are rendered, a face cuts into
a curved object by up to spacing^2 / (8 radius). `settle` moves face points along the object's normal to a stated
clearance: positive leaves a thin gap (optically dry), negative lets the object's surface stand out of the face
(optically wet).
"""

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.deform.deformation import TOUCHING_GAP_MM
from magicsim.geometry.indenter import Indenter

FACE_BAND_MM = 0.03
"""Width of the zone beyond what touches in which a face point's correction fades out [mm]: a wider one would close gaps
that are open."""
BAND_MM = 0.2
"""Width of the zone in which the correction of points behind the face fades out [mm]."""
ITERATIONS = 4
"""Corrections along the normal; one is exact on planes and spheres, rounded edges need a few."""


def settle(
    points_mm: Array,
    is_face: Mask,
    indenter: Indenter,
    clearance_mm: float,
) -> Array:
    """Moves points near an object so that the face keeps its clearance and nothing behind it is inverted.

    Face points with a distance of at most `TOUCHING_GAP_MM`, or of the clearance, end at `clearance_mm`; the correction
    fades smoothly over `FACE_BAND_MM`. Other points are pushed strictly beyond the clearance, in the order of their
    distance.

    Args:
        points_mm: Deformed positions, shape (points, 3) [mm].
        is_face: Which of them lie on the contact face, shape (points,).
        indenter: The object in its pose.
        clearance_mm: Distance of touching face points from the object's surface [mm]; negative is inside.
    """
    settled = np.array(points_mm, dtype=np.float64)
    distance, normal = indenter.distance(settled)
    touch = max(TOUCHING_GAP_MM, clearance_mm)
    near = np.flatnonzero(distance < touch + BAND_MM)
    if len(near) == 0:
        return settled
    target = np.where(
        is_face[near],
        face_distance(distance[near], clearance_mm, touch),
        interior_distance(distance[near], clearance_mm),
    )
    moved, now, along = settled[near], distance[near], normal[near]
    for _ in range(ITERATIONS):
        moved = moved + (target - now)[:, None] * along
        now, along = indenter.distance(moved)
    settled[near] = moved
    return settled


def face_distance(distance: Array, clearance_mm: float, touch_mm: float) -> Array:
    """Distance after settling: the clearance up to `touch_mm`, unchanged from `FACE_BAND_MM` beyond, a cubic between.

    Once differentiable and increasing for clearance <= touch.
    """
    t = np.clip((distance - touch_mm) / FACE_BAND_MM, 0, 1)
    end = touch_mm + FACE_BAND_MM
    blended = clearance_mm + (end - clearance_mm) * t**2 * (3 - 2 * t) + FACE_BAND_MM * t**2 * (t - 1)
    return np.asarray(np.where(distance >= end, distance, blended))


def interior_distance(distance: Array, clearance_mm: float) -> Array:
    """Distance of interior points after settling: strictly increasing, above the clearance, unchanged far away."""
    beyond = distance - clearance_mm
    lifted = (beyond + np.sqrt(beyond**2 + (BAND_MM / 4) ** 2)) / 2
    t = np.clip(beyond / BAND_MM, 0, 1)
    fade = t**2 * (3 - 2 * t)
    return np.asarray(clearance_mm + (1 - fade) * lifted + fade * beyond)
