"""Light that arrives on the object, gathered by rays from its surface.

Few particles of the light pass land on an object, and where it is seen through the block their noise is most of an
image's. A ray from the object meets what a camera path meets: cached fluence of the cells, LEDs, flashlight and room
(final gathering, Jensen 1996). What of it meets the object again takes the irradiance of the particles, which is noisy
but has few such paths.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.light.aligned import columns
from magicsim.light.backend import dr, mi
from magicsim.light.transport.path_starts import ObjectStarts
from magicsim.light.transport.sequence import sequence
from magicsim.light.world.medium import CLEARANCE
from magicsim.light.world.shapes import Shapes, in_body, mesh_of

NEAR_MM = 2.0
"""Distance from the block over which an object's surface gets half as many rays: light there varies less and less."""
LEAST_FACING = 0.1
"""Share of its rays that a surface keeps which faces away from the block."""
RAYS_PER_MM2 = 50.0
"""Rays for each mm2 of a surface that faces the block at no distance: where there are fewer, they are doubled."""
DOUBLINGS = 2
"""How often, at most."""
BESIDE = 0.1
"""Share of its rays that a surface keeps which is seen at the edge of the picture at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectRays:
    """Rays from the object's surface, their directions with the cosine's density."""

    starts: ObjectStarts
    triangle: Index
    """The triangle of each."""
    area_mm2: Array
    """Area that each stands for [mm2]."""


def object_rays(
    scene: Any, shapes: Shapes, count: int, *, seed: int, beside: tuple[int, int] = (0, 0)
) -> ObjectRays:  # fmt: skip
    """Spreads rays over the object, most of them where it is close to the block and faces it.

    Args:
        scene: The loaded scene.
        shapes: Its shapes by their role, an object among them.
        count: Number of rays; a large object gets twice or four times as many.
        seed: Random stream.
        beside: First triangle that is at the edge of the picture at most, and the first one after these.
    """
    mesh = mesh_of(shapes.object)
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1) / 2
    normals = cross / np.maximum(2 * area, 1e-30)[:, None]
    away_mm = np.maximum(-corners[:, :, 2].mean(1), 0)
    share = area * np.maximum((1 + normals[:, 2]) / 2, LEAST_FACING) / (1 + away_mm / NEAR_MM) ** 2
    share[slice(*beside)] *= BESIDE
    ends = np.cumsum(share)
    wanted = np.log2(max(1.0, RAYS_PER_MM2 * float(ends[-1]) / count))
    count *= 2 ** min(DOUBLINGS, int(np.ceil(wanted)))
    start = mi.PCG32(size=1, initstate=dr.opaque(mi.UInt64, seed))
    shift = [start.next_uint32() for _ in range(4)]
    triangle = np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1])
    represented = np.divide(area, share, out=np.zeros_like(area), where=share > 0) * ends[-1] / count
    right, up, *turns = sequence(dr.arange(mi.UInt32, count), shift)
    # Uniform over a triangle: the square folded along its diagonal.
    folded = right + up > 1
    right, up = dr.select(folded, 1 - right, right), dr.select(folded, 1 - up, up)
    a, b, c, normal = (mi.Point3f(*columns(each[triangle])) for each in (*corners.swapaxes(0, 1), normals))
    frame = mi.Frame3f(mi.Normal3f(normal))
    point = a + right * (b - a) + up * (c - a)
    point = dr.fma(CLEARANCE * (1 + dr.max(dr.abs(point))), frame.n, point)
    rays = mi.Ray3f(point, frame.to_world(mi.warp.square_to_cosine_hemisphere(mi.Point2f(*turns))))
    inside = mi.Bool(False) if shapes.outside is not None else in_body(scene, shapes, point)
    numbers = dr.arange(mi.UInt32, count)
    dr.eval(numbers, rays, inside)
    return ObjectRays(
        starts=ObjectStarts.of(numbers, rays, mi.Float(1), inside),
        triangle=triangle,
        area_mm2=represented[triangle],
    )
