"""Irradiance of the object's surface, cached by the light pass, so that camera paths may end there.

A diffuse surface sends out reflectance * irradiance / pi in every direction. Tracing on from it at random instead
finds the LEDs only by rare chance, which shows as single glaring pixels.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.arrays import Array, Index, Mask
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.kernels import kernel

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
OWN = 1e-9
"""Least weight of a triangle's own patch, also where that lies out of reach or faces away."""
MOST_BOXES = 64
"""Most boxes along an axis in which patches are looked for."""
KEPT = 8
"""Kernels that are kept: episodes press objects of the same shape."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IrradianceKernel:
    """How deposits on triangles become a smooth irradiance; depends on the rigid shape only."""

    parts: tuple[tuple[sp.csr_matrix, sp.csr_matrix], ...]
    """For each width which triangles make up a patch, shape (patches, triangles), and the kernel between triangles and
    patches, shape (triangles, patches)."""
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
                spread = self.spread(values)
                known = side & (spread[:, -1] > 0)
                result[known] = spread[known, :-1] / spread[known, -1:]
        return result

    def spread(self, values: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.floating[Any]]:
        """Sums of what triangles have over those that share light with each, both of shape (triangles, channels)."""
        return np.asarray(sum(weights @ (patches @ values) for patches, weights in self.parts))


def widened(gathered: Callable[[int], Array], away_mm: Array) -> Array:
    """Irradiance, smoothed the more the further a triangle is from the block, shape (triangles, channels)."""
    result = np.zeros_like(gathered(0))
    for level, share in _levels(away_mm):
        result += share[:, None] * gathered(level)
    return result


def blended_kernel(mesh: SurfaceMesh, away_mm: Array) -> IrradianceKernel:
    """One kernel of single precision that widens in this way, for many samples of surfaces that stay as far apart."""
    shares = ((SMOOTHING_MM * 2**level, share / 4.0**level) for level, share in _levels(away_mm))
    return _kernel_of(mesh, *shares, kind="float32")


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
    return _kernel_of(mesh, (width_mm, np.ones(len(mesh.faces))), kind="float64")


def _kernel_of(mesh: SurfaceMesh, *shares: tuple[float, Array], kind: str) -> IrradianceKernel:
    """Sum of kernels of some widths [mm], each by its share at every triangle, shape (triangles,)."""
    parts = tuple((width_mm, share.tobytes()) for width_mm, share in shares)
    return _kernel(mesh.vertices.tobytes(), mesh.faces.tobytes(), parts, kind)


@lru_cache(KEPT)
def _kernel(vertices: bytes, faces: bytes, shares: tuple[tuple[float, bytes], ...], kind: str) -> IrradianceKernel:
    corners = np.frombuffer(vertices).reshape(-1, 3)[np.frombuffer(faces, np.int32).reshape(-1, 3)]
    centres = corners.mean(1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(cross, axis=1)
    areas, parts = np.maximum(double_area, 1e-30), []
    for width_mm, share in ((width_mm, np.frombuffer(each)) for width_mm, each in shares):
        patches = _patches(centres, cross, PATCH * width_mm, kind)
        places = (patches @ (centres * areas[:, None])) / (patches @ areas)[:, None]
        rows = np.flatnonzero(share)
        order, runs = _boxes(places, centres[rows], REACH * width_mm)
        own, directions = patches.tocsc().indices, _unit(patches @ cross)
        found = _near(
            centres, cross / areas[:, None], share, own, places, directions, rows, order, runs, width_mm
        )  # fmt: skip
        matrix = sp.csr_matrix((found[0].astype(kind), *found[1:]), (len(centres), len(places)))
        parts.append((patches, matrix))
    return IrradianceKernel(parts=tuple(parts), areas_mm2=double_area / 2)


def _boxes(places: Array, centres: Array, reach_mm: float) -> tuple[Index, Index]:
    """Places sorted into boxes, and the nine runs of them in which what is near each centre lies, (centres, 9, 2)."""
    size, low = np.ptp(places, 0), places.min(0)
    edge = max(reach_mm, float(size.max()) / MOST_BOXES)
    counts = (size // edge).astype(np.int64) + 1
    strides = np.array([counts[1] * counts[2], counts[2], 1])
    box = ((places - low) // edge).astype(np.int64) @ strides
    order = np.argsort(box, kind="stable")
    begin = np.searchsorted(box[order], np.arange(counts.prod() + 1))
    x, y, z = ((centres - low) // edge).astype(np.int64).T
    runs = np.zeros((len(centres), 9, 2), np.int64)
    for number, (aside, along) in enumerate(np.ndindex(3, 3)):
        right, up = x + aside - 1, y + along - 1
        is_there = (right >= 0) & (right < counts[0]) & (up >= 0) & (up < counts[1])
        column = right * strides[0] + up * strides[1]
        for end, deep in enumerate((z - 1, z + 2)):
            runs[:, number, end] = begin[(column + deep.clip(0, counts[2])) * is_there]
    return order, runs


@kernel()
def _near(centres, normals, share, own, places, directions, rows, order, runs, width_mm):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Values, columns and starts of rows of a kernel's matrix, of which `rows` hold something."""
    most = (runs[:, :, 1] - runs[:, :, 0]).sum() + len(rows)
    values, columns, lengths = np.empty(most), np.empty(most, np.int32), np.zeros(len(centres), np.int32)
    count = 0
    for index, row in enumerate(rows):
        mine, count = count, count + 1
        values[mine], columns[mine] = OWN * share[row], own[row]
        for run in range(runs.shape[1]):
            for number in range(runs[index, run, 0], runs[index, run, 1]):
                patch = order[number]
                squared, facing = 0.0, 0.0
                for axis in range(3):
                    squared += (centres[row, axis] - places[patch, axis]) ** 2
                    facing += normals[row, axis] * directions[patch, axis]
                if squared <= (REACH * width_mm) ** 2 and facing > FACING:
                    value = share[row] * np.exp(-squared / (2 * width_mm**2))
                    if patch == own[row]:
                        values[mine] += value
                    else:
                        values[count], columns[count] = value, patch
                        count += 1
        lengths[row] = count - mine
    starts = np.zeros(len(centres) + 1, np.int32)
    starts[1:] = np.cumsum(lengths)
    return values[:count].copy(), columns[:count].copy(), starts


def _patches(centres: Array, normals: Array, edge_mm: float, kind: str) -> sp.csr_matrix:
    """Triangles of one voxel whose normals have the same main direction."""
    voxels = np.floor(centres / edge_mm).astype(np.int64)
    voxels -= voxels.min(0)
    main = np.abs(normals).argmax(1)
    side = np.take_along_axis(normals, main[:, None], 1)[:, 0] > 0
    most = voxels.max(0) + 1
    # one number for each voxel and each of six main directions
    code = ((voxels[:, 0] * most[1] + voxels[:, 1]) * most[2] + voxels[:, 2]) * 6 + 2 * main + side
    _, patch = np.unique(code, return_inverse=True)
    count = len(centres)
    return sp.csr_matrix((np.ones(count, kind), (patch, np.arange(count))), shape=(patch.max() + 1, count))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30))
