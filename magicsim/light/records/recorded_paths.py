"""Camera paths through the undeformed block, recorded once and used for every frame in which nothing touches it.

What stands outside neither bends a path within the block nor scatters it. So the image is a matrix times the fluence,
plus what the rays that left the block meet outside. Only what a glossy object mirrors is traced on, through the block
again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.arrays import Array, Index, Mask, Numbers
from magicsim.light.backend import aligned, dr, floats, in_rows, mi, pointer
from magicsim.light.transport.cached_light import Elements
from magicsim.light.transport.camera_pass import ROULETTE_WEIGHT
from magicsim.light.transport.path_record import PathRecord, Regions
from magicsim.light.transport.path_starts import ObjectStarts
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.medium import leave
from magicsim.light.world.room_light import missed

Follow = Callable[[ObjectStarts], Any]
"""Radiance that mirrored paths meet, mi.Color3f."""
FEW_SEGMENTS = 9
"""Room at first for the ways of one path that scatter: in the mean it has 4.4, 6.4, 7.1 at cells of 1, 0.8, 0.6 mm."""
BOX_SLACK = 1e-3
"""Room between a scene and the box around it, in its longest edge."""
AT_ONCE = 1_200_000
"""Paths that are traced together: bounds the memory."""
MIRROR_STREAM = 0x9E3779B97F4A7C15
"""Random stream of the choices at a mirror."""
WEIGHT = 6
"""Place of the weight among a ray's floats."""
MOMENTS = 4
"""Moments of a response: to a cell's mean, and to its slopes along x, y and z."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedPaths:
    """Paths of all pixels of a film."""

    direct: Array
    """Radiance of each pixel from lights that its paths meet, shape (pixels, 3)."""
    response: sp.csr_matrix
    """Radiance of each pixel for the light in the elements, cells and voxels, then for its slopes along x, y and z,
    shape (pixels, 4 * elements)."""
    rays: Any
    """Rays that left, pixel by pixel: origin [mm], direction, weight, nothing; mi.Float."""
    first: Any
    """Number of each pixel's first ray, and of all rays; mi.UInt32 of size pixels + 1."""
    owner: Numbers
    """The pixel of each ray."""
    samples: int
    regions: Regions | None
    """Boxes that the paths met surfaces in, if they were asked for."""
    met: npt.NDArray[np.uint32]
    """Which, one bit each, shape (words, pixels)."""

    @classmethod
    def of(
        cls, direct: Array, response: sp.csr_matrix, rays: npt.NDArray[Any], owner: npt.NDArray[Any], samples: int, *,
        regions: Regions | None = None, met: npt.NDArray[np.uint32] | None = None,
    ) -> Self:  # fmt: skip
        """From arrays, rays of shape (rays, 8) or in a row, sorted by their pixels."""
        first = np.searchsorted(owner, np.arange(len(direct) + 1))
        return cls(
            direct=direct, response=response, rays=floats(np.ravel(rays)),
            first=mi.UInt32(aligned(first, np.uint32)), owner=np.asarray(owner, np.uint32), samples=samples,
            regions=regions, met=np.zeros((0, len(direct)), np.uint32) if met is None else met,
        )  # fmt: skip

    def glow(self, light: Elements, pixels: Numbers) -> Array:
        """Radiance that light in the elements sends to some pixels, shape (pixels, 3)."""
        values = np.concatenate([light.values, *light.slopes.swapaxes(0, 1)]).astype(np.float32)
        # Rows are copied where they are chosen, which takes longer than the product.
        is_whole = np.array_equal(pixels, np.arange(self.response.shape[0]))
        return np.asarray((self.response if is_whole else self.response[pixels]) @ values, np.float64)

    def rays_of(self, pixels: Numbers) -> tuple[Any, Any]:
        """Numbers of the first ray of some pixels, and of the one after their last, mi.UInt32."""
        numbers = mi.UInt32(aligned(pixels, np.uint32))
        return dr.gather(mi.UInt32, self.first, numbers), dr.gather(mi.UInt32, self.first, numbers + 1)

    def meet(self, boxes: npt.NDArray[np.uint32], pixels: Numbers) -> Mask:
        """Which pixels have a path that met a surface in one of some boxes, shape (pixels,)."""
        found = np.zeros(self.met.shape[1], bool)
        for word in np.flatnonzero(boxes):
            found |= (self.met[word] & boxes[word]) != 0
        return found[pixels]

    def seen_outside(
        self, environment: Any, outside: Outside, irradiance: Array, finish: Finish, pixels: Numbers, *,
        room: Any = None,
    ) -> Array:  # fmt: skip
        """Radiance that some pixels get from what stands outside, less that of the room behind it, shape (pixels, 3).

        `environment` shines from all around where nothing stands before the block; of the room `room` alone shines, all
        lights by default. Pixels are numbered row by row.
        """
        numbers = self._towards(outside.scene, pixels)
        if not len(numbers):
            return np.zeros((len(pixels), 3))
        lit = floats(irradiance)
        shape, lamps = pointer(outside.object), room is None
        room = environment if lamps else room
        met = in_rows(_met_outside(outside.scene, room, shape, lit, finish, self.rays, numbers, lamps))
        owner = self.owner[np.array(numbers)]
        return np.stack([np.bincount(owner, each, len(self.direct))[pixels] for each in met.T], 1).astype(float)

    def _towards(self, scene: Any, pixels: Numbers) -> Any:
        """Numbers of the rays of some pixels that meet the box around a scene, mi.UInt32: most rays do not."""
        if len(pixels) < len(self.direct):
            first = np.array(self.first).astype(np.int64)
            begin, count = first[pixels], first[pixels + 1] - first[pixels]
            own = np.arange(count.sum()) + np.repeat(begin - np.cumsum(count) + count, count)
            numbers = mi.UInt32(aligned(own, np.uint32))
        else:
            numbers = dr.arange(mi.UInt32, len(self.owner))
        if not len(numbers):  # nothing leaves a black block, and the renderer cannot gather nothing
            return numbers
        box = scene.bbox()
        slack = BOX_SLACK * max(box.extents())
        ends = (mi.Point3f(*[dr.opaque(mi.Float, x) for x in end]) for end in (box.min - slack, box.max + slack))
        ray, _ = escaped(self.rays, numbers)
        is_met, _, farther = mi.BoundingBox3f(*ends).ray_intersect(ray)
        return dr.gather(mi.UInt32, numbers, dr.compress(is_met & (farther > 0)))

    def seen_of_room(self, room: Any, pixels: Numbers) -> Array:
        """Radiance that some pixels get from all around where nothing stands in the way, shape (pixels, 3)."""
        if not len(self.owner):
            return np.zeros((len(pixels), 3))
        return in_rows(_met_room(room, self.rays, *self.rays_of(pixels)))

    def mirrored(
        self, outside: Outside, finish: Finish, pixels: Numbers, follow: Follow, *, samples: int, seed: int
    ) -> Array:
        """Radiance that some pixels get by way of a glossy object's mirror, shape (pixels, 3)."""
        result = np.zeros((len(pixels), 3))
        if outside.object is None or finish.specular == 0:
            return result
        place = np.full(self.response.shape[0], -1)
        place[pixels] = np.arange(len(pixels))
        stride = max(1, self.samples // samples)
        chosen = np.arange(seed % stride, len(self.owner), stride)
        chosen = chosen[place[self.owner[chosen]] >= 0]
        if not len(chosen):
            return result
        numbers = mi.UInt32(aligned(chosen, np.uint32))
        ray, weight = _mirror(outside.scene, pointer(outside.object), finish, self.rays, numbers, seed, self.samples)
        kept = dr.compress(weight > 0)
        if not len(kept):
            return result
        rays = mi.Ray3f(dr.gather(mi.Point3f, ray.o, kept), dr.gather(mi.Vector3f, ray.d, kept))
        starts = ObjectStarts.of(
            dr.gather(mi.UInt32, numbers, kept), rays, dr.gather(mi.Float, weight, kept), mi.Bool(False)
        )
        met = in_rows(follow(starts)) * (stride / self.samples)
        at = place[self.owner[chosen[np.array(kept)]]]
        return np.stack([np.bincount(at, met[:, channel], len(pixels)) for channel in range(3)], 1)


@dr.syntax  # type: ignore[untyped-decorator]
def _met_room(room: Any, rays: Any, begin: Any, end: Any) -> Any:
    """Sum over each pixel's rays of what the room sends along them."""
    number, radiance = mi.UInt32(begin), mi.Color3f(0.0)
    while number < end:
        ray, weight = escaped(rays, number)
        radiance += weight * room.eval(missed(ray), number < end)
        number += 1
    return radiance


def _mirror(scene: Any, shape: Any, finish: Finish, rays: Any, numbers: Any, seed: int, samples: int) -> Any:
    """Mirrored rays and their weights, 0 where there is none: light ones survive in proportion to their weight."""
    ray, weight = escaped(rays, numbers)
    si = scene.ray_intersect(ray)
    facet, chance = mirror_samples(numbers, dr.opaque(mi.UInt64, seed))
    direction, share = finish.mirror(si, facet)
    weight *= share * dr.opaque(mi.Float, samples)
    survive = dr.minimum(weight / ROULETTE_WEIGHT, 1)
    kept = si.is_valid() & (si.shape == shape) & (chance < survive)
    result = leave(si, si.to_world(direction)), dr.select(kept, weight / survive, 0)
    dr.eval(result)
    return result


def mirror_samples(numbers: Any, seed: Any) -> tuple[Any, Any]:
    """Random numbers of each ray at a mirror: of its facet, mi.Point2f, and whether it goes on, mi.Float."""
    stream = mi.UInt64(numbers)
    sampler = mi.PCG32(size=1, initstate=stream)
    sampler.seed(seed + stream, MIRROR_STREAM + stream)
    return mi.Point2f(sampler.next_float32(), sampler.next_float32()), sampler.next_float32()


def escaped(rays: Any, number: Any) -> tuple[Any, Any]:
    """A ray that left, and its weight."""
    one = dr.gather(mi.Vector4f, rays, 2 * number)
    two = dr.gather(mi.Vector4f, rays, 2 * number + 1)
    return mi.Ray3f(mi.Point3f(one.x, one.y, one.z), mi.Vector3f(one.w, two.x, two.y)), two.z


def _met_outside(
    scene: Any, room: Any, shape: Any, lit: Any, finish: Finish, rays: Any, numbers: Any, lamps: bool
) -> Any:
    """What each ray brings, mi.Color3f."""
    ray, weight = escaped(rays, numbers)
    si = scene.ray_intersect(ray)
    on_object = si.is_valid() & (si.shape == shape)
    flux = mi.Color3f(*[dr.gather(mi.Float, lit, 3 * si.prim_index + channel, on_object) for channel in range(3)])
    found = dr.select(on_object, flux * finish.diffuse(si, on_object), 0)
    on_light = si.is_valid() & ~on_object & lamps
    found += dr.select(on_light, si.emitter(scene, on_light).eval(si, on_light), 0)
    if room is not None:
        found -= dr.select(si.is_valid(), room.eval(missed(ray), si.is_valid()), 0)
    return weight * found


def record_paths(
    trace: Callable[[range, int], tuple[PathRecord, Array]], *, pixels: int, centres_mm: Array, samples: int,
    regions: Regions | None,
) -> RecordedPaths:  # fmt: skip
    """Records paths, a few samples at a time.

    `trace` records some paths of all pixels, given the numbers of their samples and the room for segments; it gives the
    sum of the radiance of the lights that they meet, shape (pixels, 3).
    """
    cells, turns = len(centres_mm), max(1, AT_ONCE // pixels)
    room = FEW_SEGMENTS * pixels * min(turns, samples)
    codes, moments = np.zeros(0, np.int64), np.zeros((0, MOMENTS), np.float32)
    lanes, rays, direct = [], [], np.zeros((pixels, 3))
    met = np.zeros((regions.words if regions is not None else 0, pixels), np.uint32)
    for begin in range(0, samples, turns):
        part = range(begin, min(begin + turns, samples))
        record, seen = trace(part, room)
        while (taken := record.read()) is None:
            room *= 2
            record, seen = trace(part, room)
        direct += seen / samples
        if regions is not None:
            met |= np.array(record.met)[: met.size].reshape(met.shape)
        (lane, cell, gains), (lane_outside, escaped) = taken
        lanes.append(lane_outside)
        escaped[:, WEIGHT] /= samples
        rays.append(escaped)
        gain = gains[:, :1] / np.float32(samples)
        away = gains[:, 1:] - centres_mm[cell].astype(np.float32)
        found = _summed(lane.astype(np.int64) * cells + cell, gain * np.hstack([np.ones_like(gain), away]))
        both = _summed(np.concatenate([codes, found[0]]), np.concatenate([moments, found[1]])) if len(codes) else found
        codes, moments = both
    owner = np.concatenate(lanes)
    order = np.argsort(owner, kind="stable")
    columns = codes[:, None] % cells + cells * np.arange(MOMENTS)
    rows = np.repeat(codes // cells, MOMENTS)
    response = sp.csr_matrix((moments.ravel(), (rows, columns.ravel())), shape=(pixels, MOMENTS * cells))
    return RecordedPaths.of(
        direct, response, np.concatenate(rays)[order], owner[order], samples, regions=regions, met=met
    )


def _summed(codes: Index, values: npt.NDArray[np.float32]) -> tuple[Any, Any]:
    """Codes in order, each once, and the sums of the values that had it."""
    order = np.argsort(codes, kind="stable")
    codes = codes[order]
    starts = np.flatnonzero(np.diff(codes, prepend=-1))
    return codes[starts], np.add.reduceat(values[order], starts)
