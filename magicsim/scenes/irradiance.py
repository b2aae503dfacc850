"""Irradiance of the object's surface, cached by the light pass, so that camera paths may end there.

A diffuse surface sends out reflectance * irradiance / pi in every direction. Tracing on from it at random instead
finds the LEDs only by rare chance, which shows as single glaring pixels.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.spatial import cKDTree

from magicsim.geometry.mesh import SurfaceMesh

Array = npt.NDArray[np.float64]
SMOOTHING_MM = 0.7
"""Standard deviation of the kernel that spreads deposits over neighbouring triangles [mm]: irradiance under a
scattering block varies over the height of the block, and a narrower kernel is noisier."""
REACH = 2.0
"""Kernel radius in standard deviations."""
FACING = 0.5
"""Smallest cosine between the normals of two triangles that share light: none leaks around an edge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IrradianceKernel:
    """How deposits on triangles become a smooth irradiance; depends on the rigid shape only."""

    weights: sp.csr_matrix
    """Kernel between triangles, shape (triangles, triangles)."""
    areas_mm2: Array
    """Kernel-weighted area around each triangle, shape (triangles,) [mm2]."""

    def irradiance(self, deposits: Array) -> Array:
        """Irradiance from flux deposits, both of shape (triangles, channels)."""
        # Triangles without an area, which no ray meets, get nothing instead of 0 / 0.
        return np.asarray((self.weights @ deposits) / np.maximum(self.areas_mm2, 1e-30)[:, None])


def irradiance_kernel(mesh: SurfaceMesh) -> IrradianceKernel:
    """Gaussian kernel between the triangles of a rigid mesh that lie close and face alike."""
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(cross, axis=1)
    normals = cross / np.maximum(double_area, 1e-30)[:, None]
    tree = cKDTree(corners.mean(1))
    distances = tree.sparse_distance_matrix(tree, REACH * SMOOTHING_MM, output_type="coo_matrix")
    row, column = distances.row, distances.col
    facing = np.einsum("ij,ij->i", normals[row], normals[column]) > FACING
    values = np.exp(-(distances.data**2) / (2 * SMOOTHING_MM**2)) * facing
    count = len(mesh.faces)
    weights = sp.csr_matrix((values, (row, column)), shape=(count, count)) + sp.eye(count, format="csr") * 1e-9
    return IrradianceKernel(weights=sp.csr_matrix(weights), areas_mm2=weights @ (double_area / 2))
