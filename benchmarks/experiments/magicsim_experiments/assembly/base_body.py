"""The base as both fingers see it: a dark body with the jack's hole, below the plug.

Contact takes the base as a half space (`assembly.jack`). What is drawn of it keeps out of the fingers,
which come beside the pin when that is deep in the hole: a ridge that goes between them, on a plate.
"""

import numpy as np
from manifold3d import Manifold

from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim_experiments.assembly.jack import Jack

DARK = (0.03, 0.03, 0.03)
"""Diffuse reflectance in linear RGB; published is a dark base, the number is assumed."""
PLATE_MM, RIDGE_MM = 40.0, 12.0
"""Half width of the plate along x and z, and of the ridge along x [mm]; assumed, as all sizes here."""
HIGH_MM, FLOOR_MM = 6.0, 5.0
"""Height of the ridge over the plate, and thickness below the hole [mm]."""
APART_MM = 0.5
"""Distance between the ridge and the faces that hold the plug [mm]."""
AROUND = 32
"""Segments of the hole."""
FACET_MM = 12.0
"""Longest edge of its triangles, each of which has a brightness of its own [mm]."""


def base_body(jack: Jack, *, apart_mm: float) -> SurfaceMesh:
    """The base in the jack's frame, with its colour.

    Args:
        jack: The hole.
        apart_mm: Distance of the contact faces that hold the plug [mm].
    """
    radius, chamfer, depth = jack.radius_mm, jack.chamfer_mm, jack.depth_mm
    ridge = max(apart_mm / 2 - APART_MM, 0.1)
    solid = _block(RIDGE_MM, ridge, 0.0, HIGH_MM) + _block(PLATE_MM, PLATE_MM, HIGH_MM, depth + HIGH_MM + FLOOR_MM)
    hole = Manifold.cylinder(depth + 1, radius, radius, AROUND).translate((0, 0, -1))
    mouth = Manifold.cylinder(2 * chamfer + 1e-3, radius + 2 * chamfer, radius, AROUND).translate((0, 0, -chamfer))
    solid -= (hole + mouth).rotate((-90, 0, 0))
    mesh = from_manifold(solid.refine_to_length(FACET_MM))
    return SurfaceMesh(vertices=mesh.vertices, faces=mesh.faces, colors=np.tile(DARK, (len(mesh.vertices), 1)))


def _block(half_x: float, half_z: float, low: float, high: float) -> Manifold:
    size = (2 * half_x, high - low, 2 * half_z)
    return Manifold.cube(size).translate((-half_x, low, -half_z))
