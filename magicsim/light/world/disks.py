"""Flat disks as one mesh."""

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh

SIDES = 24
"""Corners of a disk; its area is kept."""


def disks(centres_mm: Array, axis: Array, radius_mm: float) -> SurfaceMesh:
    """Flat disks that face along an axis, each a regular polygon of the circle's area.

    Args:
        centres_mm: Shape (disks, 3) [mm].
        axis: Unit vector of their front, shape (3,).
        radius_mm: Of the circles [mm].
    """
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    corner = radius_mm * np.sqrt(2 * np.pi / SIDES / np.sin(2 * np.pi / SIDES))
    rim = corner * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * np.cross(axis, u))
    local = np.concatenate([np.zeros((1, 3)), rim])
    fan = np.stack([np.zeros(SIDES), 1 + np.arange(SIDES), 1 + (np.arange(SIDES) + 1) % SIDES], 1).astype(np.int32)
    first = np.arange(len(centres_mm), dtype=np.int32) * len(local)
    return SurfaceMesh(
        vertices=(centres_mm[:, None] + local).reshape(-1, 3),
        faces=(first[:, None, None] + fan).reshape(-1, 3).astype(np.int32),
    )
