"""Arbitrary points follow the lattice: the trilinear map of rest positions."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array
from magicsim.deform.lattice.hexahedron import CORNERS, shape_values
from magicsim.deform.lattice.structure import Lattice


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowMap:
    """Weights of the lattice's nodes at fixed points, so that each further frame costs one product."""

    points_mm: Array
    """Rest positions, shape (points, 3) [mm]."""
    weights: sp.csr_matrix
    """Trilinear weights, shape (points, nodes)."""

    def displaced(self, displacements_mm: Array) -> Array:
        """Positions under nodal displacements of shape (nodes, 3), shape (points, 3) [mm]."""
        return np.asarray(self.points_mm + self.weights @ displacements_mm)


def follow_map(lattice: Lattice, points_mm: Array) -> FollowMap:
    """Finds the cell and the weights of each point.

    Args:
        lattice: The block at rest.
        points_mm: Rest positions, shape (points, 3) [mm]; a point outside the block moves with the nearest point in it.
    """
    index, local, boxed = [], [], lattice.flattened(points_mm)
    for axis, planes in enumerate(lattice.planes_mm):
        coordinate = boxed[:, axis]
        cell = np.clip(np.searchsorted(planes, coordinate, side="right") - 1, 0, len(planes) - 2)
        index.append(cell)
        local.append(np.clip((coordinate - planes[cell]) / np.diff(planes)[cell], 0, 1))
    nx, ny = len(lattice.planes_mm[0]), len(lattice.planes_mm[1])
    i, j, k = index
    nodes = np.stack([((k + c[2]) * ny + j + c[1]) * nx + i + c[0] for c in CORNERS], 1)
    values = shape_values(np.stack(local, 1))
    rows = np.arange(0, 8 * len(points_mm) + 1, 8)
    weights = sp.csr_matrix((values.ravel(), nodes.ravel(), rows), shape=(len(points_mm), len(lattice.nodes_mm)))
    return FollowMap(points_mm=np.asarray(points_mm, float), weights=weights)
