"""Boxes of the undeformed block, to tell which recorded paths met something that has moved since.

A path is what it was as long as no surface that bends or stops it has moved: in no box where it met one has a vertex
of a triangle moved.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.arrays import Array, Index, Mask
from magicsim.light.backend import dr, mi

Bits = npt.NDArray[np.uint32]
WORD = 32
"""Boxes that one integer tells of."""
EDGE_MM = 1.0
"""Smallest edge of a box [mm]."""
MOST_BITS = 2**31
"""Boxes times pixels at most: a quarter of a gigabyte."""


@dataclass(slots=True, kw_only=True)
class Regions:
    """Boxes in the sensor's frame, x fastest; points outside count to the nearest one."""

    origin_mm: tuple[float, float, float]
    edge_mm: float
    counts: tuple[int, int, int]

    @classmethod
    def of(cls, low_mm: Array, high_mm: Array, pixels: int) -> Self:
        """Boxes between two corners, as small as memory for so many pixels allows."""
        size, edge = np.asarray(high_mm - low_mm), EDGE_MM
        while _counts(size, edge).prod() * pixels > MOST_BITS and edge < size.max():
            edge *= 1.1
        x, y, z = _counts(size, edge).tolist()
        return cls(origin_mm=tuple(np.asarray(low_mm, float).tolist()), edge_mm=float(edge), counts=(x, y, z))

    @property
    def words(self) -> int:
        """Integers that hold one bit for each box."""
        return -(-int(np.prod(self.counts)) // WORD)

    def index(self, point: Any) -> Any:
        """Number of the box of each point, mi.UInt32."""
        place = [
            mi.UInt32(dr.clip((point[axis] - self.origin_mm[axis]) / self.edge_mm, 0, self.counts[axis] - 0.5))
            for axis in range(3)
        ]
        return place[0] + self.counts[0] * (place[1] + self.counts[1] * place[2])

    def reach(self, vertices: Array, faces: npt.NDArray[np.int32]) -> sp.csr_matrix:
        """Which boxes the triangles of each vertex reach, shape (boxes, vertices).

        Args:
            vertices: At rest, shape (vertices, 3) [mm].
            faces: Triangles.
        """
        corners, shape = vertices[faces], (int(np.prod(self.counts)), len(vertices))
        low, high = (self._places(end) for end in (corners.min(1), corners.max(1)))
        boxes, owners = [], []
        for step in product(range(2), repeat=3):
            boxes.append(self._number(np.minimum(low + step, high)))
            owners.append(np.arange(len(faces)))
        for triangle in np.flatnonzero((high - low > 1).any(1)):
            inner = [np.arange(a, b + 1) for a, b in zip(low[triangle], high[triangle], strict=True)]
            found = self._number(np.stack(np.meshgrid(*inner), -1).reshape(-1, 3))
            boxes.append(found)
            owners.append(np.full(len(found), triangle))
        box, corner = np.repeat(np.concatenate(boxes), 3), faces[np.concatenate(owners)].ravel()
        return sp.csr_matrix((np.ones(len(box), np.float32), (box, corner)), shape=shape)

    def bits(self, chosen: Mask) -> Bits:
        """Some boxes, shape (boxes,), as one bit each, shape (words,)."""
        padded = np.zeros(self.words * WORD, bool)
        padded[: len(chosen)] = chosen
        return np.packbits(padded, bitorder="little").view(np.uint32)

    def _places(self, points: Array) -> Index:
        steps = np.floor((points - self.origin_mm) / self.edge_mm).astype(np.int64)
        return np.asarray(np.clip(steps, 0, np.array(self.counts) - 1))

    def _number(self, places: Index) -> Index:
        return np.asarray(places @ np.array([1, self.counts[0], self.counts[0] * self.counts[1]]))


def _counts(size_mm: Array, edge_mm: float) -> Index:
    return np.maximum(1, np.ceil(size_mm / edge_mm)).astype(np.int64)
