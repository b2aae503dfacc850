"""Irradiance of the object's surface, cached by the light pass, so that camera paths may end there.

A diffuse surface sends out reflectance * irradiance / pi in every direction. Tracing on from it at random instead
finds the LEDs only by rare chance, which shows as single glaring pixels.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Mask
from magicsim.geometry.mesh import SurfaceMesh

SMOOTHING_MM = 0.7
"""Standard deviation of the kernel that spreads deposits over neighbouring triangles [mm]: irradiance under a
scattering block varies over the height of the block, and a narrower kernel is noisier."""
WIDE_FROM_MM, WIDENING_MM = 1.5, 4.0
"""Distances from the block from which the kernel widens, and over which it becomes as wide again [mm]: light of a face
varies over lengths like the distance from it, of which the kernel then has less than a quarter."""
DOUBLINGS = 4
"""How often a kernel is made twice as wide at most."""
REACH = 2.0
"""Kernel radius in standard deviations."""
FACING = 0.5
"""Smallest cosine between the normals of two triangles that share light: none leaks around an edge."""
PATCH = 0.5
"""Edge of the voxels in which triangles that face alike are taken together, in standard deviations of the kernel, which
it widens by 1 %."""
KEPT = 8
"""Kernels that are kept: episodes press objects of the same shape."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IrradianceKernel:
    """How deposits on triangles become a smooth irradiance; depends on the rigid shape only."""

    patches: sp.csr_matrix
    """Which triangles make up a patch, shape (patches, triangles)."""
    weights: sp.csr_matrix
    """Kernel between triangles and patches, shape (triangles, patches)."""
    areas_mm2: Array
    """Areas of the triangles, shape (triangles,) [mm2]."""

    def irradiance(self, deposits: Array, wetted: Mask) -> Array:
        """Irradiance from flux deposits, both of shape (triangles, channels).

        What lands on triangles that touch the body without a film of air (`wetted`) has not crossed a gap, and differs
        so much from what lands beside them that the two are smoothed apart.
        """
        return self.gathered(deposits, self.areas_mm2, wetted, np.zeros_like(deposits))

    def gathered(self, flux: Array, areas_mm2: Array, wetted: Mask, otherwise: Array) -> Array:
        """Irradiance from each triangle's samples of the flux and the area that they stand for, as `irradiance`."""
        result = otherwise.copy()
        for side in (wetted, ~wetted):
            if side.any():
                values = np.concatenate([flux, areas_mm2[:, None]], 1) * side[:, None]
                spread = self.weights @ (self.patches @ values)
                known = side & (spread[:, -1] > 0)
                result[known] = spread[known, :-1] / spread[known, -1:]
        return result


def widened(gathered: Callable[[int], Array], away_mm: Array) -> Array:
    """Irradiance, smoothed the more the further a triangle is from the block, shape (triangles, channels)."""
    result = np.zeros_like(gathered(0))
    for level, share in _levels(away_mm):
        result += share[:, None] * gathered(level)
    return result


def blended_kernel(mesh: SurfaceMesh, away_mm: Array) -> IrradianceKernel:
    """One kernel that widens in this way, for many samples of surfaces that stay as far apart."""
    return _blended(mesh.vertices.tobytes(), mesh.faces.tobytes(), away_mm.tobytes())


@lru_cache(KEPT)
def _blended(vertices: bytes, faces: bytes, away_mm: bytes) -> IrradianceKernel:
    found = [
        (_kernel(vertices, faces, (share > 0).tobytes(), SMOOTHING_MM * 2**level), share / 4.0**level)
        for level, share in _levels(np.frombuffer(away_mm))
    ]
    return IrradianceKernel(
        patches=sp.csr_matrix(sp.vstack([each.patches for each, _ in found])),
        weights=sp.csr_matrix(sp.hstack([sp.diags(share) @ each.weights for each, share in found])),
        areas_mm2=found[0][0].areas_mm2,
    )  # fmt: skip


def _levels(away_mm: Array) -> Iterator[tuple[int, Array]]:
    """How often kernels are doubled in width, and the share of each of these at every triangle, shape (triangles,)."""
    doublings = np.log2(1 + np.maximum(away_mm - WIDE_FROM_MM, 0) / WIDENING_MM).clip(max=DOUBLINGS)
    lower = np.minimum(doublings.astype(int), DOUBLINGS - 1)
    part = doublings - lower
    for level in range(DOUBLINGS + 1):
        share = np.where(lower == level, 1 - part, np.where(lower == level - 1, part, 0))
        if share.any():
            yield level, share


def irradiance_kernel(mesh: SurfaceMesh, width_mm: float = SMOOTHING_MM) -> IrradianceKernel:
    """Gaussian kernel between triangles and patches of a mesh that lie close and face alike."""
    every = np.ones(len(mesh.faces), bool).tobytes()
    return _kernel(mesh.vertices.tobytes(), mesh.faces.tobytes(), every, width_mm)


@lru_cache(KEPT)
def _kernel(vertices: bytes, faces: bytes, wanted: bytes, width_mm: float) -> IrradianceKernel:
    rows = np.flatnonzero(np.frombuffer(wanted, bool))
    corners = np.frombuffer(vertices).reshape(-1, 3)[np.frombuffer(faces, np.int32).reshape(-1, 3)]
    centres = corners.mean(1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(cross, axis=1)
    patches = _patches(centres, cross, PATCH * width_mm)
    directions = _unit(patches @ cross)
    shares = patches @ np.maximum(double_area, 1e-30)
    places = (patches @ (centres * np.maximum(double_area, 1e-30)[:, None])) / shares[:, None]
    near = cKDTree(centres[rows]).sparse_distance_matrix(cKDTree(places), REACH * width_mm, output_type="coo_matrix")
    row = rows[near.row]
    facing = np.einsum("ij,ij->i", _unit(cross)[row], directions[near.col]) > FACING
    values = np.exp(-(near.data**2) / (2 * width_mm**2)) * facing
    # Every triangle is part of its own patch, also where that lies out of reach.
    weights = sp.csr_matrix((values, (row, near.col)), shape=patches.T.shape) + 1e-9 * patches.T.tocsr()
    return IrradianceKernel(patches=patches, weights=sp.csr_matrix(weights), areas_mm2=double_area / 2)


def _patches(centres: Array, normals: Array, edge_mm: float) -> sp.csr_matrix:
    """Triangles of one voxel whose normals have the same main direction."""
    voxels = np.floor(centres / edge_mm).astype(np.int64)
    main = np.abs(normals).argmax(1)
    side = np.take_along_axis(normals, main[:, None], 1) > 0
    _, patch = np.unique(np.hstack([voxels, main[:, None], side]), axis=0, return_inverse=True)
    count = len(centres)
    return sp.csr_matrix((np.ones(count), (patch.ravel(), np.arange(count))), shape=(patch.max() + 1, count))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30))
