"""An infill cell whose edges and corners are rounded, as fillets where walls cross leave it."""

import manifold3d
import numpy as np

from magicsim.arrays import Array, Index
from magicsim.geometry.mesh import SurfaceMesh, from_manifold

FACET_TOLERANCE = 0.005
"""Largest relative difference of the volume from that of round edges."""
REACH = np.array([0.0, 1.0, np.pi / (2 * np.sqrt(2)), 2 / np.sqrt(3)])
"""Distance of a vertex of a fillet from its axis, in units of the radius: on a face, an edge, a corner. An eighth of a
turn is one facet, and what lies under the facets is what lies under the round."""


def cell_mesh(edges_mm: Array, parts: int, radius_mm: float) -> SurfaceMesh:
    """Surface of one cell around its centre.

    Args:
        edges_mm: Of the cuboid, shape (3,) [mm].
        parts: Into which its edges are split, beside the fillets.
        radius_mm: Of the fillets, 0 for a cuboid [mm].
    """
    cube = manifold3d.Manifold.cube(tuple(edges_mm), True)
    if radius_mm == 0:
        return from_manifold(cube.refine(parts) if parts > 1 else cube)
    cell, half, steps = from_manifold(cube.refine(parts + 2)), np.asarray(edges_mm) / 2, parts + 2
    line = np.rint((cell.vertices / half + 1) / 2 * steps).astype(int)
    inner = half - radius_mm
    places = np.stack([_lines(half[axis], inner[axis], parts)[line[:, axis]] for axis in range(3)], 1)
    core = np.clip(places, -inner, inner)
    away = places - core
    reach = radius_mm * REACH[(np.abs(away) > radius_mm / 2).sum(1)] / np.linalg.norm(away, axis=1)
    return SurfaceMesh(vertices=core + reach[:, None] * away, faces=cell.faces)


def _lines(half: float, inner: float, parts: int) -> Array:
    """Places of the mesh lines along an axis: the ends, and the flat part split evenly."""
    return np.array([-half, *np.linspace(-inner, inner, parts + 1), half])


def cell_volume_mm3(edges_mm: Array, radius_mm: float) -> float:
    """Volume of a cuboid with round edges and corners (Steiner's formula) [mm3].

    Args:
        edges_mm: Of the cuboid, shape (3,) [mm].
        radius_mm: Of its edges [mm].
    """
    a, b, c = (float(edge) - 2 * radius_mm for edge in edges_mm)
    r = radius_mm
    return a * b * c + 2 * r * (a * b + b * c + c * a) + np.pi * r**2 * (a + b + c) + 4 / 3 * np.pi * r**3


def facing_vertices(cell: Array, axis: int) -> tuple[Index, Index]:
    """Vertices of a cell on its upper face along an axis, and those opposite them; a printed face is not quite flat.

    Args:
        cell: All of its vertices, shape (vertices, 3) [mm].
        axis: 0 to 2.
    """
    places, rows = cell[:, axis], np.sqrt((len(cell) - 2) / 6)
    slack = np.ptp(places) / (2 * rows)  # half of the way to the next row of vertices
    high, low = np.flatnonzero(places > places.max() - slack), np.flatnonzero(places < places.min() + slack)
    across = np.delete(cell, axis, axis=1)
    opposite = np.linalg.norm(across[high, None] - across[low], axis=2).argmin(1)
    return high, low[opposite]
