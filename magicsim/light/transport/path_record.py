"""What camera paths through the undeformed block pass, taken down while they are traced."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.light.backend import dr, mi
from magicsim.light.transport.regions import WORD, Regions

STEPS = 256
"""More than the interactions of a path: entries are numbered by path times this plus the interaction."""
SEGMENTS_PER_ESCAPE = 4
"""About as many ways that scatter as there are to each ray that leaves a millimetre grid."""


@dataclass(slots=True, kw_only=True)
class Gathered:
    """What paths gather on a stretch; every field is a Dr.Jit array over paths."""

    element: Any
    """Cell, or the number of cells plus the voxel of the body."""
    gain: Any
    """Radiance for a unit of fluence."""
    place: Any
    """Where that is taken from [mm]."""
    active: Any
    """Which paths gather anything."""

    def otherwise(self, *, element: Any, gain: Any, place: Any, active: Any) -> Self:
        """What other paths gather, where these do not."""
        return type(self)(
            element=dr.select(self.active, self.element, element),
            gain=dr.select(self.active, self.gain, gain),
            place=dr.select(self.active, self.place, place),
            active=self.active | active,
        )


@dataclass(slots=True, kw_only=True)
class PathRecord:
    """Entries in no fixed order, each with a number of its own; arrays on the renderer's side."""

    regions: Regions | None
    """Boxes whose surfaces a path may meet; None where nobody asks which."""
    met: Any
    """One bit for each box that a lane's paths met a surface in, mi.UInt32, `regions.words` a lane."""
    turns: Any
    """Paths of each lane, one after the other, mi.UInt32 of size 1."""
    segment_room: Any
    """Segments that there is room for, mi.UInt32 of size 1."""
    escape_room: Any
    """Escapes that there is room for, mi.UInt32 of size 1."""
    segment_count: Any
    """Segments that were met so far, also those without room, mi.UInt32 of size 1."""
    escape_count: Any
    """Escapes that were met so far, also those without room, mi.UInt32 of size 1."""
    segments: Any
    """Number of each way that scatters, mi.UInt32."""
    elements: Any
    """Its cell, or the number of cells plus its voxel of the body, mi.UInt32."""
    gains: Any
    """Radiance for a unit of fluence, and the place that it is taken from [mm]; four floats."""
    escapes: Any
    """Number of each ray that meets nothing, mi.UInt32."""
    rays: Any
    """Its origin [mm], direction, weight, and nothing; eight floats."""

    @classmethod
    def empty(cls, capacity: int, turns: int, *, lanes: int = 0, regions: Regions | None = None) -> Self:
        """Room for as many segments.

        Args:
            capacity: Number of segments.
            turns: Paths of each lane.
            lanes: Number of lanes.
            regions: Boxes to tell which of them paths met surfaces in.
        """
        fewer = capacity // SEGMENTS_PER_ESCAPE
        return cls(
            regions=regions,
            met=dr.zeros(mi.UInt32, max(1, lanes * regions.words if regions is not None else 1)),
            # Opaque: the compiled kernel then serves any number of paths.
            turns=dr.opaque(mi.UInt32, turns),
            segment_room=dr.opaque(mi.UInt32, capacity),
            escape_room=dr.opaque(mi.UInt32, fewer),
            segment_count=dr.zeros(mi.UInt32, 1),
            escape_count=dr.zeros(mi.UInt32, 1),
            segments=dr.zeros(mi.UInt32, capacity),
            elements=dr.zeros(mi.UInt32, capacity),
            gains=dr.zeros(mi.Float, 4 * capacity),
            escapes=dr.zeros(mi.UInt32, fewer),
            rays=dr.zeros(mi.Float, 8 * fewer),
        )

    def number(self, lane: Any, turn: Any, step: Any) -> Any:
        """Number of an entry: in the order of lanes, their turns, and the interactions of a path."""
        return (lane * self.turns + turn) * STEPS + step

    def mark(self, lane: Any, point: Any, active: Any) -> None:
        """Takes down that a lane's path met a surface at a point."""
        if self.regions is not None:
            box = self.regions.index(point)
            bit = mi.UInt32(1) << (box % WORD)
            dr.scatter_reduce(dr.ReduceOp.Or, self.met, bit, lane * self.regions.words + box // WORD, active)

    def add_segment(self, number: Any, met: Gathered) -> None:
        """Takes down a way that scatters."""
        slot = dr.scatter_inc(self.segment_count, mi.UInt32(0), met.active)
        active = met.active & (slot < self.segment_room)
        dr.scatter(self.segments, number, slot, active)
        dr.scatter(self.elements, met.element, slot, active)
        place = met.place
        dr.scatter(self.gains, mi.Vector4f(met.gain, place.x, place.y, place.z), slot, active)

    def add_escape(self, number: Any, ray: Any, weight: Any, active: Any) -> None:
        """Takes down a ray that meets nothing."""
        slot = dr.scatter_inc(self.escape_count, mi.UInt32(0), active)
        active = active & (slot < self.escape_room)
        dr.scatter(self.escapes, number, slot, active)
        dr.scatter(self.rays, mi.Vector4f(ray.o.x, ray.o.y, ray.o.z, ray.d.x), 2 * slot, active)
        dr.scatter(self.rays, mi.Vector4f(ray.d.y, ray.d.z, weight, 0), 2 * slot + 1, active)

    def read(self) -> tuple[tuple[npt.NDArray[Any], ...], tuple[npt.NDArray[Any], ...]] | None:
        """Lanes, elements, gains of the segments, lanes and rays of the escapes, in order; None if room was short."""
        segments, escapes = (int(count[0]) for count in (self.segment_count, self.escape_count))
        if segments > int(self.segment_room[0]) or escapes > int(self.escape_room[0]):
            return None
        per_lane = STEPS * int(self.turns[0])
        numbers = np.array(self.segments)[:segments]
        order = np.argsort(numbers)
        ways = (numbers[order] // per_lane, np.array(self.elements)[order], np.array(self.gains).reshape(-1, 4)[order])
        numbers = np.array(self.escapes)[:escapes]
        order = np.argsort(numbers)
        return ways, (numbers[order] // per_lane, np.array(self.rays).reshape(-1, 8)[order])
