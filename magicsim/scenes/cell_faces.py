"""The deformed faces of all cells, laid out for rays that look for the next wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.backend import mi
from magicsim.scenes.cell_topology import FACES, CellTopology, canonical_triangles

Array = npt.NDArray[np.float64]
PACKET = 4
"""Floats that are fetched together."""
NONE = 2**32 - 1
"""Stands for no cell."""
CONVEX_MM = 1e-5
"""Cells whose edges lie at most this deep below the plane beside them count as convex [mm]."""
DENT_MARGIN = 4.0
"""A ray that stays this many deviations of a face away from it cannot have met one of its dents (see `next_hit`)."""
WALL_MARGIN = 6.0
"""Walls this many times thicker than their faces deviate are crossed before a ray can meet the face that it left."""
FRAME = 16
"""Floats that describe a cell's frame."""


@dataclass(slots=True, kw_only=True)
class CellFaces:
    """Arrays on the renderer's side."""

    parts: int
    """Quads along an edge of a face."""
    patches: Any
    """Vertices of each face of each cell, `stride` floats a face [mm]."""
    stride: int
    frames: Any
    """Of each cell, `FRAME` floats: by rows the matrix into the cell's own frame, in which it is about [-1, 1]^3; its
    centre [mm]; how far from its faces, in that frame, a ray must stay."""
    neighbours: Any
    """Cell across each face of each cell, mi.UInt32, `NONE` where there is none that the argument holds for."""
    face_of: Any
    """Face of each triangle of a cell, mi.UInt32."""
    triangles: Any
    """Mesh triangle of each canonical triangle of each face of a cell, mi.UInt32."""
    normals: Any
    """Outward normal of each canonical triangle of each face of each cell, `PACKET` floats a triangle."""

    @property
    def per_face(self) -> int:
        """Triangles of a face."""
        return 2 * self.parts**2

    @property
    def per_cell(self) -> int:
        """Triangles of a cell."""
        return FACES * self.per_face


def cell_faces(vertices: Array, topology: CellTopology) -> CellFaces:
    """Lays out the faces of a deformed grid.

    Args:
        vertices: Of all cells, cell after cell, shape (vertices, 3) [mm].
        topology: How a cell is put together.
    """
    cells = int(np.prod(topology.counts))
    corners = vertices.reshape(cells, -1, 3)
    faces, normals = corners[:, topology.corners], triangle_normals(corners, topology)
    stride = -(-3 * faces.shape[2] // PACKET) * PACKET
    patches = np.zeros((cells * FACES, stride), np.float32)
    patches[:, : 3 * faces.shape[2]] = faces.reshape(cells * FACES, -1)
    centres = faces.mean(2)
    axes = (centres[:, 1::2] - centres[:, ::2]) / 2
    inward = np.linalg.inv(axes.transpose(0, 2, 1))
    frames = np.zeros((cells, FRAME))
    frames[:, :9], frames[:, 9:12] = inward.reshape(cells, 9), centres.mean(1)
    deviation = _deviation(faces, centres, inward)
    frames[:, 12] = np.where(dents_mm(corners, normals, topology) > CONVEX_MM, DENT_MARGIN * deviation, 0.0)
    neighbours = topology.neighbours()
    half = np.linalg.norm(axes, axis=2).repeat(2, 1)
    across = centres[neighbours, np.arange(FACES) ^ 1]
    wall = np.linalg.norm(across - centres, axis=2)
    neighbours[WALL_MARGIN * deviation[:, None] * half > wall] = -1
    return CellFaces(
        parts=topology.parts,
        patches=mi.Float(patches.ravel()),
        stride=stride,
        frames=mi.Float(frames.astype(np.float32).ravel()),
        neighbours=mi.UInt32(np.where(neighbours < 0, NONE, neighbours).astype(np.uint32).ravel()),
        face_of=mi.UInt32(topology.face_of.astype(np.uint32)),
        triangles=mi.UInt32(topology.triangles.astype(np.uint32).ravel()),
        normals=mi.Float(np.pad(normals, ((0, 0), (0, 0), (0, 1))).ravel()),
    )


def triangle_normals(corners: Array, topology: CellTopology) -> npt.NDArray[np.float32]:
    """Outward unit normals of the canonical triangles of each face of each cell, shape (cells, triangles, 3).

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        topology: How a cell is put together.
    """
    a, b, c = (np.asarray(corners[:, index], np.float32) for index in _triangles(topology).T)
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-30), np.float32)


def dents_mm(corners: Array, normals: npt.NDArray[np.float32], topology: CellTopology) -> Array:
    """How far each cell is from convex: the largest height of a triangle's tip over the plane of the one beside it.

    Args:
        corners: Vertices of each cell, shape (cells, vertices of a cell, 3) [mm].
        normals: See `triangle_normals`.
        topology: How a cell is put together.

    Returns:
        Shape (cells,) [mm].
    """
    triangles = _triangles(topology)
    plane, tip = _beside(triangles)
    above = np.asarray(corners[:, tip] - corners[:, triangles[plane, 0]], np.float32)
    return np.asarray(np.einsum("cti,cti->ct", normals[:, plane], above).max(1), np.float64)


def _triangles(topology: CellTopology) -> npt.NDArray[np.int64]:
    return np.asarray(topology.corners[:, canonical_triangles(topology.parts)].reshape(-1, 3))


def _deviation(faces: Array, centres: Array, inward: Array) -> Array:
    """Largest distance of a cell's faces from those of the box that is its frame, in units of half its size."""
    relative = faces - centres.mean(1)[:, None, None]
    along = np.stack([relative[:, 2 * a : 2 * a + 2] @ inward[:, None, a, :, None] for a in range(3)], 1)[..., 0]
    return np.asarray(np.abs(np.abs(along) - 1).max((1, 2, 3)), np.float64)


def _beside(triangles: npt.NDArray[np.int64]) -> tuple[list[int], list[int]]:
    """For each edge: a triangle, and the tip of the other triangle of that edge."""
    turned = [np.roll(triangles, -turn, axis=1).tolist() for turn in range(3)]
    owner = {(a, b): (number, tip) for corners in turned for number, (a, b, tip) in enumerate(corners)}
    pairs = [(owner[edge][0], owner[edge[::-1]][1]) for edge in owner if edge[0] < edge[1]]
    return [plane for plane, _ in pairs], [tip for _, tip in pairs]
