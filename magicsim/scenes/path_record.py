"""What camera paths through the undeformed block pass, taken down while they are traced."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.scenes.backend import dr, mi

STEPS = 256
"""More than the interactions of a path: entries are numbered by path times this plus the interaction."""
SEGMENTS_PER_ESCAPE = 4
"""About as many ways through cells as there are to each ray that leaves a millimetre grid."""


@dataclass(slots=True, kw_only=True)
class PathRecord:
    """Entries in no fixed order, each with a number of its own; arrays on the renderer's side."""

    turns: Any
    """Paths of each lane, one after the other, mi.UInt32 of size 1."""
    segment_room: Any
    """Segments that there is room for, mi.UInt32 of size 1."""
    escape_room: Any
    """The same of escapes."""
    segment_count: Any
    """Segments that were met so far, also those without room, mi.UInt32 of size 1."""
    escape_count: Any
    """The same of escapes."""
    segments: Any
    """Number of each way through a cell, mi.UInt32."""
    cells: Any
    """Its cell, mi.UInt32."""
    gains: Any
    """Weight times the share that the way scatters, and the place where the mean of it happens [mm]; four floats."""
    escapes: Any
    """Number of each ray that meets nothing, mi.UInt32."""
    rays: Any
    """Its origin [mm], direction, weight, and nothing; eight floats."""

    @classmethod
    def empty(cls, capacity: int, turns: int) -> Self:
        """Room for as many segments."""
        fewer = capacity // SEGMENTS_PER_ESCAPE
        return cls(
            # Opaque: the compiled kernel then serves any number of paths.
            turns=dr.opaque(mi.UInt32, turns),
            segment_room=dr.opaque(mi.UInt32, capacity),
            escape_room=dr.opaque(mi.UInt32, fewer),
            segment_count=dr.zeros(mi.UInt32, 1),
            escape_count=dr.zeros(mi.UInt32, 1),
            segments=dr.zeros(mi.UInt32, capacity),
            cells=dr.zeros(mi.UInt32, capacity),
            gains=dr.zeros(mi.Float, 4 * capacity),
            escapes=dr.zeros(mi.UInt32, fewer),
            rays=dr.zeros(mi.Float, 8 * fewer),
        )

    def number(self, lane: Any, turn: Any, step: Any) -> Any:
        """Of an entry: in the order of lanes, their turns, and the interactions of a path."""
        return (lane * self.turns + turn) * STEPS + step

    def add_segment(self, number: Any, cell: Any, gain: Any, place: Any, active: Any) -> None:
        """Takes down a way through a cell."""
        slot = dr.scatter_inc(self.segment_count, mi.UInt32(0), active)
        active = active & (slot < self.segment_room)
        dr.scatter(self.segments, number, slot, active)
        dr.scatter(self.cells, cell, slot, active)
        dr.scatter(self.gains, mi.Vector4f(gain, place.x, place.y, place.z), slot, active)

    def add_escape(self, number: Any, ray: Any, weight: Any, active: Any) -> None:
        """Takes down a ray that meets nothing."""
        slot = dr.scatter_inc(self.escape_count, mi.UInt32(0), active)
        active = active & (slot < self.escape_room)
        dr.scatter(self.escapes, number, slot, active)
        dr.scatter(self.rays, mi.Vector4f(ray.o.x, ray.o.y, ray.o.z, ray.d.x), 2 * slot, active)
        dr.scatter(self.rays, mi.Vector4f(ray.d.y, ray.d.z, weight, 0), 2 * slot + 1, active)

    def read(self) -> tuple[tuple[npt.NDArray[Any], ...], tuple[npt.NDArray[Any], ...]] | None:
        """Lanes, cells and gains of the segments, lanes and rays of the escapes, in order; None if room was short."""
        segments, escapes = (int(count[0]) for count in (self.segment_count, self.escape_count))
        if segments > int(self.segment_room[0]) or escapes > int(self.escape_room[0]):
            return None
        per_lane = STEPS * int(self.turns[0])
        numbers = np.array(self.segments)[:segments]
        order = np.argsort(numbers)
        ways = (numbers[order] // per_lane, np.array(self.cells)[order], np.array(self.gains).reshape(-1, 4)[order])
        numbers = np.array(self.escapes)[:escapes]
        order = np.argsort(numbers)
        return ways, (numbers[order] // per_lane, np.array(self.rays).reshape(-1, 8)[order])
