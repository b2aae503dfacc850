"""Where light particles start: on a light, or outside the block where recorded ones meet what stands there."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

from magicsim.light.backend import dr, mi
from magicsim.light.transport.streams import sequence
from magicsim.light.world.room_light import Beam, PassingPart, room_particles

CHUNK = 500_000
"""Particles traced at once: bounds the memory, does not change the result."""
TURNS = 8
"""Particles that a lane traces one after the other: 8 to 32 take the same time, 1 a third more."""
FIXED_POINT = 2.0**24
"""Integer steps per unit of (weight x mm) in which particles leave light behind, see `light_pass`."""
FAINT = 2.0**-10
"""Weight below which particles need more steps than these."""
ROOM_PART = 4
"""The room gets the strips' particles divided by this: it brings a fraction of their light."""
ROUND_OBJECT = 0.5
"""Particles of the room's beam around an object for each one of the beam through the opening."""


def steps_of(brightest: float) -> float:
    """Integer steps that are fine enough for particles of this weight."""
    return FIXED_POINT * 2.0 ** max(0, math.ceil(math.log2(FAINT / brightest))) if brightest > 0 else FIXED_POINT


class Sent(NamedTuple):
    """Particles that one light sends out."""

    emitter: Any
    """The light."""
    first: int
    """Index of the first particle, so that a large number can be traced in chunks."""
    particles: int
    """Number of particles."""
    seed: int
    """Random stream of the light."""
    inside: bool
    """Whether the light shines inside the body."""
    place: int
    """Number of the light among all that are traced."""
    beam: Beam | None = None
    """Part of the light that comes from all around, or None where it does not."""
    weight: float = 1.0
    """Weight of each particle: that of a light's particles over those of this beam of it."""
    steps: float = FIXED_POINT
    """See `steps_of`."""


@dataclass(slots=True, kw_only=True)
class LightStarts:
    """Particles of one light or of several, one after the other; arrays on the renderer's side."""

    rays: Any
    weights: Any
    brightest: Any
    """Brightest channel of the weight with which each was sent out."""
    steps: Any
    """Integer steps per unit of weight x mm of each one's light, mi.Float."""
    seeds: Any
    """Where each one's random numbers start, mi.UInt64."""
    streams: Any
    """Index of each among all of its light's, mi.UInt64."""
    places: Any
    """Number of the light of each, mi.UInt32."""
    inside: Any
    """Which start inside the body, mi.Bool."""
    count: Any
    """Number of particles, mi.UInt32 of size 1."""
    particles: int
    """Number of particles, as Python knows it."""

    @classmethod
    def emitted(cls, parts: Sequence[Sent]) -> Self:
        """Starts of the particles of some lights."""
        found = [_first_rays(part) for part in parts]
        rays, weights, *others = zip(*found, strict=True)
        total = sum(part.particles for part in parts)
        origins, directions, carried = (
            [dr.concat([one[axis] for one in each]) for axis in range(3)]
            for each in ([ray.o for ray in rays], [ray.d for ray in rays], weights)
        )
        brightest, steps, seeds, streams, places, inside = (dr.concat(each) for each in others)
        return cls(
            rays=mi.Ray3f(mi.Point3f(*origins), mi.Vector3f(*directions)), weights=mi.Color3f(*carried),
            brightest=brightest, steps=steps, seeds=seeds, streams=streams, places=places, inside=inside,
            count=dr.opaque(mi.UInt32, total), particles=total,
        )  # fmt: skip

    @classmethod
    def escaped(
        cls, numbers: Any, rays: Any, weights: Any, brightest: Any, *, seed: int, steps: float = FIXED_POINT
    ) -> Self:
        """Starts of particles that left the untouched block and meet something outside; each has its own number."""
        size = dr.width(numbers)
        # Numbers of its own for each particle, whichever others meet something.
        streams = mi.UInt64(numbers)
        starts = cls(
            rays=rays, weights=weights, brightest=brightest, steps=dr.opaque(mi.Float, steps, size),
            seeds=dr.opaque(mi.UInt64, seed) + streams, streams=streams, places=dr.zeros(mi.UInt32, size),
            inside=dr.zeros(mi.Bool, size), count=dr.opaque(mi.UInt32, size), particles=size,
        )  # fmt: skip
        dr.eval(starts)
        return starts

    def some(self, kept: Any) -> Self:
        """Some of these particles, by their places, mi.UInt32."""
        kinds = {
            "weights": mi.Color3f, "brightest": mi.Float, "steps": mi.Float, "seeds": mi.UInt64, "streams": mi.UInt64,
            "places": mi.UInt32, "inside": mi.Bool,
        }  # fmt: skip
        starts = type(self)(
            rays=self.ray(kept, True), count=dr.opaque(mi.UInt32, len(kept)), particles=len(kept),
            **{name: dr.gather(kind, getattr(self, name), kept) for name, kind in kinds.items()},
        )  # fmt: skip
        dr.eval(starts)
        return starts

    def ray(self, number: Any, active: Any) -> Any:
        """First ray of each particle."""
        return mi.Ray3f(
            dr.gather(mi.Point3f, self.rays.o, number, active), dr.gather(mi.Vector3f, self.rays.d, number, active)
        )


def _first_rays(part: Sent) -> tuple[Any, ...]:
    """First rays of the particles of one light and what belongs to them, in the order of the fields above."""
    start = mi.PCG32(size=1, initstate=dr.opaque(mi.UInt64, part.seed))
    shift = [start.next_uint32() for _ in range(4)]
    number = dr.arange(mi.UInt64, part.particles)
    # Opaque: the compiled kernel then serves any chunk.
    stream = number + dr.opaque(mi.UInt64, part.first)
    u = sequence(mi.UInt32(stream), shift)
    if part.beam is not None:
        is_passing = isinstance(part.emitter, PassingPart)
        ray, weight = part.emitter.rays(part.beam, u) if is_passing else room_particles(part.emitter, part.beam, u=u)
        weight *= dr.opaque(mi.Float, part.weight)
    else:
        places = mi.Point2f(u[0], u[1]), mi.Point2f(u[2], u[3])
        ray, weight = part.emitter.sample_ray(mi.Float(0), mi.Float(0.5), *places)
    weight = mi.Color3f(weight)
    found = (
        mi.Ray3f(ray), weight + dr.zeros(mi.Color3f, part.particles), dr.max(weight),
        dr.opaque(mi.Float, part.steps, part.particles), dr.opaque(mi.UInt64, part.seed) + number, stream,
        mi.UInt32(0) + dr.opaque(mi.UInt32, part.place, part.particles),
        dr.opaque(mi.Bool, part.inside, part.particles),
    )  # fmt: skip
    dr.eval(found)
    return found


def chunks(parts: Sequence[Sent]) -> Iterator[list[Sent]]:
    """All particles of some lights, as many at once as memory allows."""
    chosen: list[Sent] = []
    room = CHUNK
    for part in parts:
        done = 0
        while done < part.particles:
            taken = min(room, part.particles - done)
            chosen.append(part._replace(first=part.first + done, particles=taken))
            done, room = done + taken, room - taken
            if room == 0:
                yield chosen
                chosen, room = [], CHUNK
    if chosen:
        yield chosen
