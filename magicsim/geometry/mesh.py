"""A triangle mesh as two arrays, and what can be said of it."""

from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceMesh:
    """Closed triangle mesh, outward by the right-hand rule."""

    vertices: npt.NDArray[np.float64]
    """Vertex positions, shape (vertices, 3) [mm]."""
    faces: npt.NDArray[np.int32]
    """Vertex indices, shape (triangles, 3)."""
    colors: npt.NDArray[np.float64] | None = None
    """Diffuse reflectance of each vertex in linear RGB, shape (vertices, 3); None without colours of its own."""

    def volume_mm3(self) -> float:
        """Enclosed volume by the divergence theorem [mm3]."""
        a, b, c = (self.vertices[self.faces[:, corner]] for corner in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    def is_watertight(self) -> bool:
        """Whether every directed edge has exactly one opposite partner."""
        edges = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]]).astype(np.int64)
        count = len(self.vertices)
        forward = np.sort(edges[:, 0] * count + edges[:, 1])
        backward = np.sort(edges[:, 1] * count + edges[:, 0])
        return bool(np.array_equal(forward, backward) and (np.diff(forward) > 0).all())


def from_manifold(solid: manifold3d.Manifold) -> SurfaceMesh:
    """Arrays of a Manifold3D solid."""
    mesh = solid.to_mesh64()
    return SurfaceMesh(
        vertices=np.array(mesh.vert_properties[:, :3], dtype=np.float64),
        faces=np.array(mesh.tri_verts, dtype=np.int32),
    )
