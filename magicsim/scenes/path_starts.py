"""Where camera paths start: at the pinhole, or outside the block where a recorded path was mirrored back towards it."""

from dataclasses import dataclass
from typing import Any, Self

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.window import Window

PATTERN_SEED = 1
"""Of the first pixel pattern, a fixed quadrature for all seeds: only chance at interfaces depends on the seed."""


@dataclass(slots=True, kw_only=True)
class CameraStarts:
    """Rays from the pinhole, one lane a pixel of a window, which takes its samples one after the other."""

    sensor: Any
    columns: Any
    rows: Any
    pixel: Any
    """Number of each lane's pixel in the whole film, mi.UInt32."""
    corner: Any
    scramble: list[Any]
    """Bits that scramble each pixel's pattern, one mi.UInt32 a dimension."""
    samples: Any
    """Of a pixel in all, mi.UInt32 of size 1."""
    begin: Any
    end: Any
    """Numbers of the samples that are traced, mi.UInt32 of size 1."""
    depth: int = 0
    """Interactions before the start."""

    @classmethod
    def of(cls, sensor: Any, *, samples: int, window: Window, pattern: int, part: range) -> Self:
        """Of a part of the film.

        Args:
            sensor: Of the scene.
            samples: Camera samples a pixel.
            window: Part of the film.
            pattern: Another number scrambles every pixel's pattern at random: errors of images are then independent.
            part: Numbers of the samples of each pixel that are traced; the others count as dark.
        """
        columns, rows = sensor.film().size()
        place = dr.arange(mi.UInt32, window.columns * window.rows)
        pixel = (window.row + place // window.columns) * columns + window.column + place % window.columns
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
        """Of each path at its start."""
        return mi.Color3f(1.0)


@dataclass(slots=True, kw_only=True)
class MirroredStarts:
    """Rays that a glossy object sends back, one lane each; they start in the air."""

    pixel: Any
    """A number of each path, no two alike, mi.UInt32."""
    rays: Any
    weights: Any
    begin: Any
    end: Any
    """Numbers of the only path of a lane and of the next, mi.UInt32 of size 1."""
    depth: int = 1
    """Interactions before the start."""

    @classmethod
    def of(cls, numbers: Any, rays: Any, weights: Any) -> Self:
        """Of rays with weights, each with a number of its own."""
        begin, end = dr.opaque(mi.UInt32, 0), dr.opaque(mi.UInt32, 1)
        return cls(pixel=numbers, rays=rays, weights=weights, begin=begin, end=end)

    def stream(self, index: Any) -> Any:
        """Number of each lane's path among all, mi.UInt64."""
        return mi.UInt64(self.pixel) + mi.UInt64(index)

    def ray(self, _index: Any) -> Any:
        """The first ray of each lane's path."""
        return mi.Ray3f(self.rays)

    def weight(self) -> Any:
        """Of each path at its start."""
        return mi.Color3f(self.weights)


PathStarts = CameraStarts | MirroredStarts
