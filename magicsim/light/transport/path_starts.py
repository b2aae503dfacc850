"""Where camera paths start: at the pinhole, or on the object, where light is asked for or a path was mirrored."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from magicsim.arrays import Numbers
from magicsim.light.aligned import aligned
from magicsim.light.backend import dr, mi

PATTERN_SEED = 1
"""Seed of the first pixel pattern, a fixed quadrature for all seeds: only chance at interfaces depends on the seed."""


@dataclass(slots=True, kw_only=True)
class CameraStarts:
    """Rays from the pinhole, one lane a pixel, which takes its samples one after the other."""

    sensor: Any
    columns: Any
    rows: Any
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
    depth: int = 0
    """Interactions before the start."""

    @classmethod
    def of(cls, sensor: Any, *, samples: int, pixels: Numbers, pattern: int, part: range) -> Self:
        """Starts at a part of the film.

        Args:
            sensor: Of the scene.
            samples: Camera samples a pixel.
            pixels: Numbers of the pixels, row by row of the film, one lane each.
            pattern: Another number scrambles every pixel's pattern at random: errors of images are then independent.
            part: Numbers of the samples of each pixel that are traced; the others count as dark.
        """
        columns, rows = sensor.film().size()
        pixel = mi.UInt32(aligned(pixels, np.uint32))
        corner = mi.Point2f(mi.Float(pixel % columns), mi.Float(pixel // columns))
        numbers = mi.PCG32(size=columns * rows, initstate=dr.opaque(mi.UInt64, PATTERN_SEED + pattern))
        scramble = [dr.gather(mi.UInt32, numbers.next_uint32(), pixel) for _ in range(2)]
        dr.eval(scramble, corner)
        # Opaque: the compiled kernel then serves any number of samples.
        per_pixel, begin, end = (dr.opaque(mi.UInt32, number) for number in (samples, part.start, part.stop))
        return cls(
            sensor=sensor, columns=columns, rows=rows, pixel=pixel, corner=corner, scramble=scramble, samples=per_pixel,
            begin=begin, end=end,
        )  # fmt: skip

    def stream(self, index: Any) -> Any:
        """Number of each lane's path among all, mi.UInt64."""
        return mi.UInt64(self.pixel) * mi.UInt64(self.samples) + mi.UInt64(index)

    def ray(self, index: Any) -> Any:
        """The first ray of each lane's path."""
        number, (across, down) = mi.UInt32(index), self.scramble
        right, below = mi.radical_inverse_2(number, across), mi.sobol_2(number, down)
        position = mi.Point2f((self.corner.x + right) / self.columns, (self.corner.y + below) / self.rows)
        sampled = self.sensor.sample_ray(mi.Float(0), mi.Float(0.5), position, mi.Point2f(0.5, 0.5))
        return mi.Ray3f(sampled[0])

    def weight(self) -> Any:
        """Weight of each path at its start."""
        return mi.Color3f(1.0)

    def in_body(self) -> Any:
        """Whether each path starts inside the body."""
        return mi.Bool(False)


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
    """Interactions before the start."""

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

    def weight(self) -> Any:
        """Weight of each path at its start."""
        return mi.Color3f(self.weights)

    def in_body(self) -> Any:
        """Whether each path starts inside the body."""
        return mi.Bool(self.inside)


PathStarts = CameraStarts | ObjectStarts
