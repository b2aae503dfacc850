"""What camera paths through the undeformed block pass, taken down while they are traced."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array, Index, Mask
from magicsim.light.backend import box_number, copied, dr, mi

Bits = npt.NDArray[np.uint32]
WORD = 32
"""Boxes that one integer tells of."""
EDGE_MM = 1.0
"""Smallest edge of a box [mm]."""
MOST_BITS = 2**31
"""Boxes times pixels at most: a quarter of a gigabyte."""
STEPS = 256
"""More than the interactions of a path: entries are numbered by path times this plus the interaction."""
SEGMENTS_PER_ESCAPE = 4
"""About as many ways that scatter as there are to each ray that leaves a millimetre grid."""


@dataclass(slots=True, kw_only=True)
class Regions:
    """Boxes of the undeformed block, to tell which recorded paths met something that has moved since.

    A path is what it was as long as no surface that bends or stops it has moved: in no box where it met one has a
    vertex of a triangle moved. Boxes are in the sensor's frame, x fastest; points outside count to the nearest one.
    """

    origin_mm: tuple[float, float, float]
    edge_mm: float
    counts: tuple[int, int, int]

    @classmethod
    def of(cls, low_mm: Array, high_mm: Array, pixels: int) -> Self:
        """Boxes between two corners, as small as memory for so many pixels allows."""
        size, edge = np.asarray(high_mm - low_mm), EDGE_MM
        while _counts(size, edge).prod() * pixels > MOST_BITS and edge < size.max():
            edge *= 1.1
        x, y, z = _counts(size, edge).tolist()
        return cls(origin_mm=tuple(np.asarray(low_mm, float).tolist()), edge_mm=float(edge), counts=(x, y, z))

    @property
    def words(self) -> int:
        """Integers that hold one bit for each box."""
        return -(-int(np.prod(self.counts)) // WORD)

    def index(self, point: Any) -> Any:
        """Number of the box of each point, mi.UInt32."""
        return box_number(point, self.origin_mm, 3 * (self.edge_mm,), self.counts)

    def reached(self, vertices: Array, faces: npt.NDArray[np.int32]) -> Mask:
        """Which boxes some triangles reach at rest, shape (boxes,)."""
        corners, found = vertices[faces], np.zeros(int(np.prod(self.counts)), bool)
        low, high = (self._places(end) for end in (corners.min(1), corners.max(1)))
        is_long = (high - low > 1).any(1)
        for chosen in (~is_long, is_long):
            first, last = low[chosen], high[chosen]
            for step in np.ndindex(*((last - first).max(0, initial=0) + 1)):
                found[self._number(np.minimum(first + step, last))] = True
        return found

    def bits(self, chosen: Mask) -> Bits:
        """Some boxes, shape (boxes,), as one bit each, shape (words,)."""
        padded = np.zeros(self.words * WORD, bool)
        padded[: len(chosen)] = chosen
        return np.packbits(padded, bitorder="little").view(np.uint32)

    def _places(self, points: Array) -> Index:
        steps = np.floor((points - self.origin_mm) / self.edge_mm).astype(np.int64)
        return np.asarray(np.clip(steps, 0, np.array(self.counts) - 1))

    def _number(self, places: Index) -> Index:
        return np.asarray(places @ np.array([1, self.counts[0], self.counts[0] * self.counts[1]]))


def _counts(size_mm: Array, edge_mm: float) -> Index:
    return np.maximum(1, np.ceil(size_mm / edge_mm)).astype(np.int64)


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
    """One bit for each box that a lane's paths met a surface in, mi.UInt32, all lanes for each of `regions.words`."""
    lanes: Any
    """Number of lanes, mi.UInt32 of size 1: `met` has room for more words than they need."""
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
    """Cell of each segment, or the number of cells plus its voxel of the body, mi.UInt32."""
    gains: Any
    """Radiance for a unit of fluence, and the place that it is taken from [mm]; four floats."""
    escapes: Any
    """Number of each ray that meets nothing, mi.UInt32."""
    rays: Any
    """Origin of each escaping ray [mm], direction, weight, and nothing; eight floats."""

    @classmethod
    def empty(cls, capacity: int, turns: int, *, lanes: int = 0, regions: Regions | None = None) -> Self:
        """Room for as many segments."""
        fewer = capacity // SEGMENTS_PER_ESCAPE
        return cls(
            regions=regions,
            met=dr.zeros(mi.UInt32, copied(lanes * regions.words if regions is not None else 1)),
            # Opaque: the compiled kernel then serves any number of paths.
            lanes=dr.opaque(mi.UInt32, lanes),
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
            dr.scatter_reduce(dr.ReduceOp.Or, self.met, bit, box // WORD * self.lanes + lane, active)

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
        numbers = [np.array(self.segments)[:segments], np.array(self.escapes)[:escapes]]
        orders = [np.argsort(each) for each in numbers]
        lanes = [each[order] // (STEPS * int(self.turns[0])) for each, order in zip(numbers, orders, strict=True)]
        ways = (lanes[0], np.array(self.elements)[orders[0]], np.array(self.gains).reshape(-1, 4)[orders[0]])
        return ways, (lanes[1], np.array(self.rays).reshape(-1, 8)[orders[1]])
