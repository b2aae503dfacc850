"""Light that left the untouched block, recorded once: frames in which nothing touches trace on what meets the object.

All other light goes where it went without the object, so the untouched state has it already. What is traced is the
difference that the object makes, and no noise of the rest comes with it.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.light.backend import columns, dr, mi, pointer
from magicsim.light.transport.light_starts import LightStarts, steps_of
from magicsim.light.world.loaded_scene import Outside

FLOATS = 12
"""Floats of an escape: origin [mm], direction, weight, the brightest channel when it was sent out, nothing."""


@dataclass(slots=True, kw_only=True)
class LightRecord:
    """Escapes in no fixed order, each with its particle's number; arrays on the renderer's side."""

    count: Any
    """Escapes so far, mi.UInt32 of size 1."""
    first: Any
    """Particles of each light from this number on are not taken down, mi.UInt32 of size 1."""
    numbers: Any
    rays: Any

    @classmethod
    def empty(cls, lights: int, first: int) -> Self:
        """Room for the first particles of some lights, each of which leaves once at most."""
        particles = max(1, lights * first)
        return cls(
            count=dr.zeros(mi.UInt32, 1),
            first=dr.opaque(mi.UInt32, first),
            numbers=dr.zeros(mi.UInt32, particles),
            rays=dr.zeros(mi.Float, FLOATS * particles),
        )

    def read(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]:
        """What left, in the order of the particles, shape (escapes, 12), and the number of each particle."""
        found = int(self.count[0])
        numbers = np.array(self.numbers)[:found]
        order = np.argsort(numbers)
        return np.array(self.rays).reshape(-1, FLOATS)[order], numbers[order]


def take_down(
    record: LightRecord | None, light: Any, starts: LightStarts, number: Any, ray: Any, weight: Any, brightest: Any,
    active: Any,
) -> None:  # fmt: skip
    """Records particles that meet nothing, if anybody does."""
    if record is None:
        return
    stream = mi.UInt32(dr.gather(mi.UInt64, starts.streams, number, active))
    active = active & (stream < record.first)
    slot = dr.scatter_inc(record.count, mi.UInt32(0), active)
    dr.scatter(record.numbers, light * record.first + stream, slot, active)
    dr.scatter(record.rays, mi.Vector4f(ray.o.x, ray.o.y, ray.o.z, ray.d.x), 3 * slot, active)
    dr.scatter(record.rays, mi.Vector4f(ray.d.y, ray.d.z, weight.x, weight.y), 3 * slot + 1, active)
    dr.scatter(record.rays, mi.Vector4f(weight.z, brightest, 0, 0), 3 * slot + 2, active)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedLight:
    """What left, of all lights."""

    rays: Any
    weights: Any
    brightest: Any
    owners: npt.NDArray[np.uint32]
    """Number of the particle of each."""
    particles: int
    """Sent out by each light."""
    steps: float
    """See `steps_of`."""

    @classmethod
    def of(cls, escapes: npt.NDArray[np.float32], owners: npt.NDArray[np.uint32], particles: int) -> Self:
        """From what `LightRecord.read` gave of lights that sent out so many particles each."""
        column = [mi.Float(each) for each in columns(escapes)]
        return cls(
            rays=mi.Ray3f(mi.Point3f(*column[:3]), mi.Vector3f(*column[3:6])),
            weights=mi.Color3f(*column[6:9]),
            brightest=column[9],
            owners=owners,
            particles=particles,
            steps=steps_of(float(escapes[:, 9].max(initial=0))),
        )

    def escapes(self) -> npt.NDArray[np.float32]:
        """What `of` takes, shape (escapes, 10)."""
        column = [*self.rays.o, *self.rays.d, *self.weights, self.brightest]
        return np.stack([np.array(each) for each in column], 1)

    def met(self, outside: Outside, *, seed: int, gone: npt.NDArray[np.bool_] | None = None) -> LightStarts | None:
        """The particles that meet the object outside, but for those that are `gone`; None where none does."""
        if not dr.width(self.brightest):  # the renderer ends the process where it is to trace no rays
            return None
        si = outside.scene.ray_intersect_preliminary(self.rays)
        meets = si.is_valid() & (si.shape == pointer(outside.object))
        if gone is not None:
            meets &= ~mi.Bool(gone[self.owners])
        kept = dr.compress(meets)
        if not len(kept):
            return None
        rays = mi.Ray3f(dr.gather(mi.Point3f, self.rays.o, kept), dr.gather(mi.Vector3f, self.rays.d, kept))
        return LightStarts.escaped(
            kept,
            rays,
            dr.gather(mi.Color3f, self.weights, kept),
            dr.gather(mi.Float, self.brightest, kept),
            seed=seed,
            steps=self.steps,
        )
