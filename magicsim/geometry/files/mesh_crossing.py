"""What is wrong with a closed surface that its edges alone do not tell: it passes through itself, or is inside out."""

import igl
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from magicsim.geometry.mesh import SurfaceMesh

JITTER = 1e-9
"""Random motion of the vertices, in units of the mesh's size: faces that lie in one plane then cross, or do not."""


def crossing_edges(surface: SurfaceMesh) -> int:
    """How many edges pass through a triangle that they do not touch; 0 where the surface keeps clear of itself.

    Two triangles that cross have an edge of one in the other, so that none is missed. Surfaces that merely touch may
    count as well.
    """
    size = float(np.ptp(surface.vertices, axis=0).max())
    moved = surface.vertices + JITTER * size * np.random.default_rng(0).uniform(-1, 1, surface.vertices.shape)
    faces = surface.faces.astype(np.int64)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    tree = igl.AABB()
    tree.init(moved, faces)
    begin = np.ascontiguousarray(moved[edges[:, 0]])
    along = np.ascontiguousarray(moved[edges[:, 1]] - begin)
    hits = [
        (edge, hit[0]) for edge, found in enumerate(tree.intersect_ray(moved, faces, begin, along)) for hit in found
        if 0 < hit[1] < 1
    ]  # fmt: skip
    if not hits:
        return 0
    edge, face = np.array(hits).T
    touches = (edges[edge][:, :, None] == faces[face][:, None, :]).any(axis=(1, 2))
    return len(np.unique(edge[~touches]))


def inside_out_parts(surface: SurfaceMesh) -> int:
    """How many of the parts that do not hang together are inside out, cavities in other parts left out."""
    faces, count = surface.faces, len(surface.vertices)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_array((np.ones(len(ends), bool), (ends[:, 0], ends[:, 1])), shape=(count, count))
    parts, part_of = connected_components(graph, directed=False)
    a, b, c = (surface.vertices[faces[:, corner]] for corner in range(3))
    volumes = np.zeros(parts)
    np.add.at(volumes, part_of[faces[:, 0]], np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)
    low, high = np.full((parts, 3), np.inf), np.full((parts, 3), -np.inf)
    np.minimum.at(low, part_of, surface.vertices)
    np.maximum.at(high, part_of, surface.vertices)
    solid, inverted = np.flatnonzero(volumes > 0), np.flatnonzero(volumes < 0)
    return sum(not ((low[solid] < low[each]) & (high[each] < high[solid])).all(axis=1).any() for each in inverted)
