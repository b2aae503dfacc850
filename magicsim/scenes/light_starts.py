"""Where light particles start: on a light, or outside the block where recorded ones meet what stands there."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.sequence import sequence

CHUNK = 500_000
"""Particles traced at once: bounds the memory, does not change the result."""
TURNS = 8
"""Particles that a lane traces one after the other: 8 to 32 take the same time, 1 a third more."""


@dataclass(slots=True, kw_only=True)
class EmitterStarts:
    """Particles that a light sends out."""

    emitter: Any
    shift: list[Any]
    """Of the light's pattern."""
    first: Any
    """Index of the first particle, mi.UInt64 of size 1."""
    count: Any
    """Number of particles, mi.UInt32 of size 1."""
    particles: int
    """The same for Python."""
    inside: bool
    """Whether they start inside the body."""

    @classmethod
    def of(cls, emitter: Any, *, first: int, particles: int, seed: int, inside: bool) -> Self:
        """Of one light.

        Args:
            emitter: The light.
            first: Index of the first particle, so that a large number can be traced in chunks.
            particles: Number of particles of this chunk.
            seed: Random stream of the light.
            inside: Whether the light shines inside the body.
        """
        start = mi.PCG32(size=1, initstate=dr.opaque(mi.UInt64, seed))
        shift = [start.next_uint32() for _ in range(4)]
        # Opaque: the compiled kernel then serves any chunk.
        begin, count = dr.opaque(mi.UInt64, first), dr.opaque(mi.UInt32, particles)
        return cls(emitter=emitter, shift=shift, first=begin, count=count, particles=particles, inside=inside)

    def stream(self, number: Any) -> Any:
        """Index of each particle among all of the light's, mi.UInt64."""
        return mi.UInt64(number) + self.first

    def begin(self, number: Any) -> tuple[Any, Any, Any]:
        """Each particle's first ray, weight, and the brightest channel of the weight with which it was sent out."""
        u = sequence(mi.UInt32(self.stream(number)), self.shift)
        places = mi.Point2f(u[0], u[1]), mi.Point2f(u[2], u[3])
        ray, weight = self.emitter.sample_ray(mi.Float(0), mi.Float(0.5), *places)
        return mi.Ray3f(ray), mi.Color3f(weight), dr.max(mi.Color3f(weight))


@dataclass(slots=True, kw_only=True)
class EscapedStarts:
    """Particles that left the untouched block and meet something outside."""

    numbers: Any
    """A number of each particle, no two alike, mi.UInt32."""
    rays: Any
    weights: Any
    brightest: Any
    count: Any
    """Number of particles, mi.UInt32 of size 1."""
    particles: int
    """The same for Python."""
    inside: bool = False

    @classmethod
    def of(cls, numbers: Any, rays: Any, weights: Any, brightest: Any) -> Self:
        """Of particles, each with a number of its own."""
        size = dr.width(numbers)
        return cls(
            numbers=numbers, rays=rays, weights=weights, brightest=brightest, count=dr.opaque(mi.UInt32, size),
            particles=size,
        )  # fmt: skip

    def stream(self, number: Any) -> Any:
        """Number of each particle among all that were recorded, mi.UInt64."""
        return mi.UInt64(dr.gather(mi.UInt32, self.numbers, number, number < self.count))

    def begin(self, number: Any) -> tuple[Any, Any, Any]:
        """Each particle's ray, weight, and the brightest channel of the weight with which it was sent out."""
        there = number < self.count
        ray = mi.Ray3f(
            dr.gather(mi.Point3f, self.rays.o, number, there), dr.gather(mi.Vector3f, self.rays.d, number, there)
        )
        return (
            ray,
            dr.gather(mi.Color3f, self.weights, number, there),
            dr.gather(mi.Float, self.brightest, number, there),
        )


LightStarts = EmitterStarts | EscapedStarts


def emitter_chunks(emitter: Any, particles: int, *, seed: int, inside: bool) -> Iterator[EmitterStarts]:
    """All particles of a light, as many at once as memory allows."""
    for first in range(0, particles, CHUNK):
        yield EmitterStarts.of(emitter, first=first, particles=min(CHUNK, particles - first), seed=seed, inside=inside)
