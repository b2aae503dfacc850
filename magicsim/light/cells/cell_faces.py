"""The deformed faces of all cells, laid out for rays that look for the next wall."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.light.aligned import aligned
from magicsim.light.backend import mi
from magicsim.light.cells.cell_planes import NEVER, dented_cells, largest_dents_mm, outward_normals
from magicsim.light.cells.cell_topology import FACES, CellTopology, canonical_triangles

PACKET = 4
"""Floats that are fetched together."""
NONE = 2**32 - 1
"""Stands for no cell."""
CONVEX_MM = 1e-5
"""Cells whose edges lie at most this deep below the plane beside them count as convex [mm]."""
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
    """Frames of each cell, `FRAME` floats: by rows the matrix into the cell's own frame, in which it is about [-1,
    1]^3; its centre [mm]; for each axis how far from its two faces, in that frame, a ray must end, see
    `dented_cells`; -inf where the cell is convex."""
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


def cell_faces(vertices: Array, topology: CellTopology, fused: Index | None = None) -> CellFaces:
    """Lays out the faces of a deformed grid.

    Args:
        vertices: Of all cells, cell after cell, shape (vertices, 3) [mm].
        topology: How a cell is put together.
        fused: Numbers of cells, of any shape, whose faces no argument holds for; none by default.
    """
    cells = int(np.prod(topology.counts))
    corners = vertices.reshape(cells, -1, 3)
    faces, triangles = corners[:, topology.corners], _triangles(topology)
    normals = outward_normals(corners, triangles)
    stride = -(-3 * faces.shape[2] // PACKET) * PACKET
    patches = np.zeros((cells * FACES, stride), np.float32)
    patches[:, : 3 * faces.shape[2]] = faces.reshape(cells * FACES, -1)
    centres = faces.mean(2)
    axes = (centres[:, 1::2] - centres[:, ::2]) / 2
    inward = np.linalg.inv(axes.transpose(0, 2, 1))
    frames = np.zeros((cells, FRAME))
    frames[:, :9], frames[:, 9:12] = inward.reshape(cells, 9), centres.mean(1)
    dented = largest_dents_mm(corners, normals, triangles, *_beside(triangles)) > CONVEX_MM
    neighbours = topology.neighbours()
    frames[:, 12:15], free = dented_cells(
        faces, canonical_triangles(topology.parts), dented, frames[:, 9:12], axes, inward, neighbours
    )
    neighbours[~(free & free[neighbours, np.arange(FACES) ^ 1])] = -1
    if fused is not None:
        frames[fused, 12:15], neighbours[fused] = NEVER, -1
        neighbours[np.isin(neighbours, fused)] = -1
    return CellFaces(
        parts=topology.parts,
        patches=mi.Float(aligned(patches, np.float32).ravel()),
        stride=stride,
        frames=mi.Float(aligned(frames, np.float32).ravel()),
        neighbours=mi.UInt32(aligned(np.where(neighbours < 0, NONE, neighbours), np.uint32).ravel()),
        face_of=mi.UInt32(topology.face_of.astype(np.uint32)),
        triangles=mi.UInt32(topology.triangles.astype(np.uint32).ravel()),
        normals=mi.Float(aligned(normals, np.float32).ravel()),
    )


def _triangles(topology: CellTopology) -> Index:
    """Vertices of the canonical triangles of all faces of a cell, shape (triangles of a cell, 3)."""
    return np.asarray(topology.corners[:, canonical_triangles(topology.parts)].reshape(-1, 3))


def _beside(triangles: Index) -> tuple[Index, Index]:
    """For each edge: a triangle, and the tip of the other triangle of that edge."""
    turned = [np.roll(triangles, -turn, axis=1).tolist() for turn in range(3)]
    owner = {(a, b): (number, tip) for corners in turned for number, (a, b, tip) in enumerate(corners)}
    pairs = [(owner[edge][0], owner[edge[::-1]][1]) for edge in owner if edge[0] < edge[1]]
    planes, tips = np.array(pairs, np.int64).T
    return planes, tips
