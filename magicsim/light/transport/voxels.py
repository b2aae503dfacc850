"""A regular grid that holds the fluence of the body, one connected region that walls and skin share.

It stands still while the sensor deforms; what a voxel holds of the body is counted by rays in every state.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.light.backend import dr, mi
from magicsim.light.world.medium import classify
from magicsim.light.world.shapes import Shapes

PLAIN_MM = 1.0
"""Edge of a voxel where there is no grid, whose pitch is taken otherwise [mm]."""
LAYERS = 6
"""Fewest layers of voxels in a thin block without a grid."""
POINTS = 5
"""Points along each edge of a voxel that say how much of it is body."""
PADDING = (1, 1, 0)
"""Layers of voxels on each side along x, y and z behind the LED strips, where it is dark."""
LEAST_SHARE = 0.02
"""Voxels with less body than this share hold no fluence: too little is known of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyPart:
    """What voxels hold of the body in one state."""

    held_mm3: Array
    """Volume, shape (voxels,) [mm3]; 0 where it is next to nothing."""
    centres_mm: Array
    """Centroid, shape (voxels, 3) [mm]."""


@dataclass(slots=True, kw_only=True)
class Voxels:
    """Boxes in the sensor's frame, x fastest; points outside count to the nearest one."""

    origin_mm: tuple[float, float, float]
    size_mm: tuple[float, float, float]
    counts: tuple[int, int, int]

    @property
    def count(self) -> int:
        """Number of voxels."""
        return int(np.prod(self.counts))

    @property
    def inner_counts(self) -> tuple[int, int, int]:
        """Voxels between the LED strips along x, y and z."""
        x, y, z = (count - 2 * layers for count, layers in zip(self.counts, PADDING, strict=True))
        return x, y, z

    @property
    def inner(self) -> npt.NDArray[np.intp]:
        """Numbers of the voxels between the LED strips, x fastest."""
        numbers = np.arange(self.count).reshape(self.counts[::-1])
        x, y, z = (slice(layers, count - layers) for layers, count in zip(PADDING, self.counts, strict=True))
        return numbers[z, y, x].ravel()

    def index(self, point: Any) -> Any:
        """Number of the voxel that holds a point."""
        place = [
            mi.UInt32(dr.clip((point[axis] - self.origin_mm[axis]) / self.size_mm[axis], 0, self.counts[axis] - 0.5))
            for axis in range(3)
        ]
        return place[0] + self.counts[0] * (place[1] + self.counts[1] * place[2])

    def body_part(self, scene: Any, shapes: Shapes) -> BodyPart:
        """What each voxel holds of the body in the scene's present state."""
        per_voxel = POINTS**3
        lane = dr.arange(mi.UInt32, self.count * per_voxel)
        voxel, point = lane // per_voxel, lane % per_voxel
        random = mi.PCG32(size=self.count * per_voxel)
        steps = (point % POINTS, (point // POINTS) % POINTS, point // POINTS**2)
        x, y = voxel % self.counts[0], (voxel // self.counts[0]) % self.counts[1]
        places = (x, y, voxel // (self.counts[0] * self.counts[1]))
        position = [
            (mi.Float(place) + (mi.Float(step) + random.next_float32()) / POINTS) * size + origin
            for place, step, size, origin in zip(places, steps, self.size_mm, self.origin_mm, strict=True)
        ]
        si = scene.ray_intersect(mi.Ray3f(mi.Point3f(*position), mi.Vector3f(0, 0, 1)))
        body, infill, _ = shapes.pointers()
        segment = classify(si, body, infill, mi.Bool(False), shapes.openings)
        inside = dr.select(segment.in_body, mi.Float(1), mi.Float(0))
        points = np.array(dr.block_sum(inside, per_voxel), np.float64)
        sums = [np.array(dr.block_sum(inside * axis, per_voxel), np.float64) for axis in position]
        known = points > LEAST_SHARE * per_voxel
        centres = np.stack(sums, 1) / np.maximum(points, 1)[:, None]
        centres[~known] = np.stack([np.array(axis).reshape(-1, per_voxel).mean(1) for axis in position], 1)[~known]
        held = np.where(known, points / per_voxel * np.prod(self.size_mm), 0.0)
        return BodyPart(held_mm3=held, centres_mm=centres)


def body_voxels(elastomer: Elastomer, inset_mm: float) -> Voxels:
    """Voxels as large as the grid's pitch, with faces where the LED strips shine from, and one more layer outside.

    Args:
        elastomer: The block at rest.
        inset_mm: Depth of the strips inside the body [mm].
    """
    design = elastomer.design
    size = np.array([*design.footprint_mm, design.height_mm]) - [2 * inset_mm, 2 * inset_mm, 0]
    plain = min(PLAIN_MM, design.height_mm / LAYERS)
    wanted = elastomer.grid.pitch_mm if elastomer.grid is not None else np.full(3, plain)
    inner = np.maximum(1, np.round(size / wanted)).astype(int)
    edge = size / inner
    outer = np.array(PADDING)
    origin = np.array([-size[0] / 2, -size[1] / 2, 0.0]) - outer * edge
    x, y, z = (inner + 2 * outer).tolist()
    return Voxels(origin_mm=tuple(origin.tolist()), size_mm=tuple(edge.tolist()), counts=(x, y, z))
