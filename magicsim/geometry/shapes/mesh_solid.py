"""A watertight triangle mesh as a rigid solid.

Distances come from a tree of bounding boxes (libigl), built once; their sign from the pseudonormal of the nearest
face, edge or vertex (Baerentzen and Aanaes 2005).
"""

from dataclasses import dataclass
from typing import Any, Self

import igl
import manifold3d
import numpy as np

from magicsim.arrays import Array, Index
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.shapes.solids import TINY, TRIANGLE_MM

FAR_MM = 0.5
"""Points farther from the bounding box than this get the distance to the box, which is never too long [mm]."""
ON_SURFACE_MM = 1e-7
"""Points nearest to an edge or a vertex, and nearer to it than this, get its pseudonormal [mm]; others the direction to
it. Above the middle of a face that direction is the face's normal, without the rounding of a short difference."""
ON_EDGE = 1e-9
"""Barycentric coordinates below this put a nearest point on an edge or a vertex."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshShape:
    """A closed triangle mesh in the frame of its file."""

    surface: SurfaceMesh
    faces: Index
    """The triangles of the surface as the tree reads them."""
    box_mm: Array
    """Least and largest coordinates, shape (2, 3) [mm]."""
    feature_mm: float
    tree: Any
    normals: Array
    """Pseudonormals, shape (7, triangles, 3): of the face, of its edges opposite to corners 0 to 2, of its corners."""

    @classmethod
    def of(cls, surface: SurfaceMesh, *, feature_mm: float | None = None) -> Self:
        """Tree and pseudonormals of a closed surface; a feature is half of its smallest extent by default."""
        faces = surface.faces.astype(np.int64)
        tree = igl.AABB()
        tree.init(surface.vertices, faces)
        box = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
        feature = feature_mm if feature_mm is not None else float((box[1] - box[0]).min()) / 2
        normals = _pseudonormals(surface)
        return cls(surface=surface, faces=faces, box_mm=box, feature_mm=feature, tree=tree, normals=normals)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`; beyond 0.5 mm from the bounding box a lower bound: distance and normal of that box."""
        beyond = points - np.clip(points, *self.box_mm)
        distance = np.linalg.norm(beyond, axis=1)
        normal = beyond / np.maximum(distance, TINY)[:, None]
        near = np.flatnonzero(distance <= FAR_MM)
        if len(near) == 0:
            return distance, normal
        place = np.ascontiguousarray(points[near])
        _, face, foot = self.tree.squared_distance(self.surface.vertices, self.faces, place)
        kind = _kind_of_foot(self.surface.vertices[self.faces[face]], foot)
        outward = self.normals[kind, face]
        offset = place - foot
        length = np.linalg.norm(offset, axis=1)
        sign = np.where(np.einsum("pi,pi->p", offset, outward) < 0, -1.0, 1.0)
        away = (sign / np.maximum(length, TINY))[:, None] * offset
        distance[near] = sign * length
        is_beside_face = (kind > 0) & (length > ON_SURFACE_MM)
        normal[near] = np.where(is_beside_face[:, None], away, outward)
        return distance, normal

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return float((self.surface.vertices @ direction).max())

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        mesh = manifold3d.Mesh64(self.surface.vertices, self.surface.faces.astype(np.uint64))
        return from_manifold(manifold3d.Manifold(mesh).refine_to_length(TRIANGLE_MM))


def _pseudonormals(surface: SurfaceMesh) -> Array:
    """Unit pseudonormals of faces, edges (mean of two faces) and vertices (weighted by angle), by triangle."""
    faces, corners = surface.faces, surface.vertices[surface.faces]
    count = len(faces)
    face_normal = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    result = np.empty((7, count, 3))
    result[0] = face_normal
    at_vertex = np.zeros_like(surface.vertices)
    edges = np.empty((3, count, 2), np.int64)
    for k in range(3):
        one, other = _unit(corners[:, (k + 1) % 3] - corners[:, k]), _unit(corners[:, (k + 2) % 3] - corners[:, k])
        angle = np.arccos(np.clip(np.einsum("ti,ti->t", one, other), -1, 1))
        np.add.at(at_vertex, faces[:, k], angle[:, None] * face_normal)
        edges[k] = np.sort(faces[:, [(k + 1) % 3, (k + 2) % 3]], axis=1)
    _, of_edge = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    at_edge = np.zeros((of_edge.max() + 1, 3))
    np.add.at(at_edge, of_edge.ravel(), np.tile(face_normal, (3, 1)))
    result[1:4] = _unit(at_edge)[of_edge.reshape(3, count)]
    result[4:7] = _unit(at_vertex)[faces.T]
    return result


def _kind_of_foot(triangles: Array, foot: Array) -> Index:
    """Where on its triangle a point lies: 0 inside, 1 to 3 on the edge opposite to corner 0 to 2, 4 to 6 there."""
    sides = [triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0], foot - triangles[:, 0]]
    aa, ab, bb = (np.einsum("ti,ti->t", sides[i], sides[k]) for i, k in ((0, 0), (0, 1), (1, 1)))
    pa, pb = (np.einsum("ti,ti->t", sides[2], side) for side in sides[:2])
    area = np.maximum(aa * bb - ab * ab, TINY)
    second, third = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    weights = np.stack([1 - second - third, second, third], axis=1)
    off = weights < ON_EDGE
    on_corner = off.sum(axis=1) > 1
    return np.where(on_corner, 4 + np.argmax(weights, axis=1), np.where(off.any(axis=1), 1 + np.argmax(off, axis=1), 0))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), TINY))
