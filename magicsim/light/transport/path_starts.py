"""Where camera paths start: at the pinhole, or on the object, where light is asked for or a path was mirrored.

Few particles of the light pass land on an object, and where it is seen through the block their noise is most of an
image's. A ray from the object meets what a camera path meets: cached fluence of the cells, LEDs, flashlight and room
(final gathering, Jensen 1996). What of it meets the object again takes the irradiance of the particles, which is noisy
but has few such paths.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from magicsim.arrays import Array, Index, Numbers
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import aligned, columns, dr, mi
from magicsim.light.transport.streams import sequence
from magicsim.light.world.medium import CLEARANCE

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
PATTERN_SEED = 1
"""Seed of the first pixel pattern."""


@dataclass(slots=True, kw_only=True)
class CameraStarts:
    """Rays from the pinhole, one lane a pixel, which takes its samples one after the other."""

    sensor: Any
    per_column: Any
    """Width of a pixel over that of the film, mi.Float of size 1."""
    per_row: Any
    pixel: Any
    """Number of each lane's pixel in the whole film, mi.UInt32."""
    corner: Any
    scramble: list[Any]
    """Bits that scramble each pixel's pattern, one mi.UInt32 a dimension."""
    samples: Any
    """Samples of a pixel in all, mi.UInt32 of size 1."""
    begin: Any
    end: Any
    """Numbers of the samples that are traced, mi.UInt32 of size 1."""
    weights: float = 1.0
    """Weight of each path at its start."""
    inside: bool = False
    """Whether paths start inside the body."""
    depth: int = 0
    """Interactions before the start."""
    asked: int = 0
    """What was asked for the lights before it, see `coating.ASKED`."""

    @classmethod
    def of(cls, sensor: Any, *, samples: int, pixels: Numbers, pattern: int, part: range) -> Self:
        """Starts at a part of the film.

        Pixels are numbered row by row, one lane each. Another pattern scrambles them at random, so that errors of
        images are independent; of the samples of each pixel only those of a part may be traced, the others counting as
        dark.
        """
        columns, rows = sensor.film().size()
        pixel = mi.UInt32(aligned(pixels, np.uint32))
        corner = mi.Point2f(mi.Float(pixel % columns), mi.Float(pixel // columns))
        numbers = mi.PCG32(size=columns * rows, initstate=dr.opaque(mi.UInt64, PATTERN_SEED + pattern))
        scramble = [dr.gather(mi.UInt32, numbers.next_uint32(), pixel) for _ in range(2)]
        dr.eval(scramble, corner)
        # Opaque: the compiled kernel then serves any number of samples.
        per_pixel, begin, end = (dr.opaque(mi.UInt32, number) for number in (samples, part.start, part.stop))
        across, down = (dr.opaque(mi.Float, float(np.float32(1) / np.float32(size))) for size in (columns, rows))
        return cls(
            sensor=sensor, per_column=across, per_row=down, pixel=pixel, corner=corner, scramble=scramble,
            samples=per_pixel, begin=begin, end=end,
        )  # fmt: skip

    def stream(self, index: Any) -> Any:
        """Number of each lane's path among all, mi.UInt64."""
        return mi.UInt64(self.pixel) * mi.UInt64(self.samples) + mi.UInt64(index)

    def ray(self, index: Any) -> Any:
        """The first ray of each lane's path."""
        number, (across, down) = mi.UInt32(index), self.scramble
        right, below = mi.radical_inverse_2(number, across), mi.sobol_2(number, down)
        position = mi.Point2f((self.corner.x + right) * self.per_column, (self.corner.y + below) * self.per_row)
        sampled = self.sensor.sample_ray(mi.Float(0), mi.Float(0.5), position, mi.Point2f(0.5, 0.5))
        return mi.Ray3f(sampled[0])


@dataclass(slots=True, kw_only=True)
class ObjectStarts:
    """Rays that leave the object, one lane each."""

    pixel: Any
    """A number of each path, no two alike, mi.UInt32."""
    rays: Any
    weights: Any
    inside: Any
    """Which start inside the body, mi.Bool."""
    begin: Any
    end: Any
    """Numbers of the only path of a lane and of the next, mi.UInt32 of size 1."""
    depth: int = 1
    asked: int = 0
    """What was asked for the lights before it, see `coating.ASKED`."""

    @classmethod
    def of(cls, numbers: Any, rays: Any, weights: Any, inside: Any) -> Self:
        """Starts of rays with weights, each with a number of its own."""
        begin, end = dr.opaque(mi.UInt32, 0), dr.opaque(mi.UInt32, 1)
        return cls(pixel=numbers, rays=rays, weights=weights, inside=inside, begin=begin, end=end)

    def stream(self, index: Any) -> Any:
        """Number of each lane's path among all, mi.UInt64."""
        return mi.UInt64(self.pixel) + mi.UInt64(index)

    def ray(self, _index: Any) -> Any:
        """The first ray of each lane's path."""
        return mi.Ray3f(self.rays)


PathStarts = CameraStarts | ObjectStarts


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectRays:
    """Rays from the object's surface, their directions with the cosine's density."""

    rays: Any
    triangle: Index
    area_mm2: Array
    """Area that each stands for [mm2]."""


def object_rays(mesh: SurfaceMesh, count: int, *, seed: int, beside: tuple[int, int] = (0, 0)) -> ObjectRays:
    """Spreads rays over an object, most of them where it is close to the block and faces it.

    A large object gets twice or four times as many rays, and triangles from the first to the second of `beside`, at the
    edge of the picture, few.
    """
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
    dr.eval(rays)
    return ObjectRays(rays=rays, triangle=triangle, area_mm2=represented[triangle])
