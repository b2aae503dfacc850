"""Camera paths through the undeformed block, recorded once and used for every frame in which nothing touches it.

What stands outside neither bends a path within the block nor scatters it. So the image is a matrix times the fluence,
plus what the rays that left the block meet outside. Only what a glossy object mirrors is traced on, through the block
again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.scenes.backend import dr, mi
from magicsim.scenes.camera_pass import ROULETTE_WEIGHT
from magicsim.scenes.finish import Finish
from magicsim.scenes.outside import Outside
from magicsim.scenes.path_record import PathRecord
from magicsim.scenes.path_starts import MirroredStarts
from magicsim.scenes.ray_start import leave

Array = npt.NDArray[np.float64]
Follow = Callable[[MirroredStarts], Array]
"""Radiance that mirrored paths meet, shape (paths, 3)."""
Numbers = npt.NDArray[np.uint32]
FEW_SEGMENTS = 6
"""Room at first for the ways through cells of one path; paths through a millimetre grid pass 4.4 in the mean."""
AT_ONCE = 600_000
"""Paths that are traced together: bounds the memory."""
MIRROR_STREAM = 0x9E3779B97F4A7C15
"""Of the choices at a mirror."""
WEIGHT = 6
"""Place of the weight among a ray's floats."""
MOMENTS = 4
"""Of a response: to a cell's mean, and to its slopes along x, y and z."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedPaths:
    """Paths of all pixels of a film."""

    response: sp.csr_matrix
    """Radiance of each pixel for the fluence of the cells, then for its slopes along x, y and z; shape (pixels,
    4 * cells)."""
    rays: Any
    """Rays that left, pixel by pixel: origin [mm], direction, weight, nothing; mi.Float."""
    first: Any
    """Number of each pixel's first ray, and of all rays; mi.UInt32 of size pixels + 1."""
    owner: Numbers
    """The pixel of each ray."""
    samples: int
    """Paths of each pixel."""

    def glow(self, fluence: Array, slopes: Array, pixels: Numbers) -> Array:
        """Radiance that a fluence sends to some pixels, shape (pixels, 3).

        Args:
            fluence: Of the cells, shape (cells, 3).
            slopes: Along x, y and z, shape (cells, 3, 3) [1/mm].
            pixels: Numbers of the pixels, row by row of the film.
        """
        values = np.concatenate([fluence, *slopes.swapaxes(0, 1)]).astype(np.float32)
        return np.asarray(self.response[pixels] @ values, np.float64)

    def seen_outside(self, outside: Outside, irradiance: Array, finish: Finish, pixels: Numbers) -> Array:
        """Radiance that some pixels get from what stands outside, shape (pixels, 3).

        Args:
            outside: What stands there.
            irradiance: Of the object's triangles, shape (triangles, 3).
            finish: Surface of the object.
            pixels: Numbers of the pixels, row by row of the film.
        """
        if not len(self.owner):  # nothing leaves a black block, and the renderer cannot loop over no rays
            return np.zeros((len(pixels), 3))
        lit = mi.Float(irradiance.astype(np.float32).ravel())
        numbers = mi.UInt32(pixels)
        begin, end = (dr.gather(mi.UInt32, self.first, numbers + step) for step in (0, 1))
        thing = mi.ShapePtr(outside.object)
        return np.array(_met_outside(outside.scene, thing, lit, finish, self.rays, begin, end), np.float64).T

    def mirrored(
        self, outside: Outside, finish: Finish, pixels: Numbers, follow: Follow, *, samples: int, seed: int
    ) -> Array:
        """Radiance that some pixels get by way of a glossy object's mirror, shape (pixels, 3).

        Args:
            outside: What stands outside.
            finish: Surface of the object.
            pixels: Numbers of the pixels, row by row of the film.
            follow: Traces the paths on.
            samples: Paths of each pixel that are traced on, about.
            seed: Random stream.
        """
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
        numbers = mi.UInt32(chosen.astype(np.uint32))
        ray, weight = _mirror(
            outside.scene, mi.ShapePtr(outside.object), finish, self.rays, numbers, seed, self.samples
        )
        kept = dr.compress(weight > 0)
        if not len(kept):
            return result
        rays = mi.Ray3f(dr.gather(mi.Point3f, ray.o, kept), dr.gather(mi.Vector3f, ray.d, kept))
        starts = MirroredStarts.of(dr.gather(mi.UInt32, numbers, kept), rays, dr.gather(mi.Float, weight, kept))
        met = follow(starts) * (stride / self.samples)
        at = place[self.owner[chosen[np.array(kept)]]]
        return np.stack([np.bincount(at, met[:, channel], len(pixels)) for channel in range(3)], 1)


def _mirror(scene: Any, thing: Any, finish: Finish, rays: Any, numbers: Any, seed: int, samples: int) -> Any:
    """Mirrored rays and their weights, 0 where there is none: light ones survive in proportion to their weight."""
    ray, weight = _escaped(rays, numbers)
    si = scene.ray_intersect(ray)
    stream = mi.UInt64(numbers)
    sampler = mi.PCG32(size=1, initstate=stream)
    sampler.seed(dr.opaque(mi.UInt64, seed) + stream, MIRROR_STREAM + stream)
    direction, share = finish.mirror(si, mi.Point2f(sampler.next_float32(), sampler.next_float32()))
    weight *= share * dr.opaque(mi.Float, samples)
    survive = dr.minimum(weight / ROULETTE_WEIGHT, 1)
    kept = si.is_valid() & (si.shape == thing) & (sampler.next_float32() < survive)
    result = leave(si, si.to_world(direction)), dr.select(kept, weight / survive, 0)
    dr.eval(result)
    return result


def _escaped(rays: Any, number: Any) -> tuple[Any, Any]:
    """A ray that left, and its weight."""
    one = dr.gather(mi.Vector4f, rays, 2 * number)
    two = dr.gather(mi.Vector4f, rays, 2 * number + 1)
    return mi.Ray3f(mi.Point3f(one.x, one.y, one.z), mi.Vector3f(one.w, two.x, two.y)), two.z


@dr.syntax  # type: ignore[untyped-decorator]
def _met_outside(scene: Any, thing: Any, lit: Any, finish: Finish, rays: Any, begin: Any, end: Any) -> Any:
    """Sum over each pixel's rays of what they bring."""
    number, radiance = mi.UInt32(begin), mi.Color3f(0.0)
    while number < end:
        ray, weight = _escaped(rays, number)
        si = scene.ray_intersect(ray)
        on_object = si.is_valid() & (si.shape == thing)
        flux = mi.Color3f(*[dr.gather(mi.Float, lit, 3 * si.prim_index + channel, on_object) for channel in range(3)])
        found = dr.select(on_object, flux * finish.diffuse(si, on_object), 0)
        on_light = si.is_valid() & ~on_object
        found += dr.select(on_light, si.emitter(scene, on_light).eval(si, on_light), 0)
        radiance += weight * found
        number += 1
    return radiance


def record_paths(
    trace: Callable[[range, int], PathRecord], *, pixels: int, centres_mm: Array, albedo: float, samples: int
) -> RecordedPaths:
    """Records paths, a few samples at a time.

    Args:
        trace: Records some paths of all pixels, given the numbers of their samples and the room for segments.
        pixels: Number of pixels.
        centres_mm: Of the cells, shape (cells, 3) [mm].
        albedo: Share of the light that a cell scatters and does not absorb.
        samples: Paths of each pixel.
    """
    cells, turns = len(centres_mm), max(1, AT_ONCE // pixels)
    room = FEW_SEGMENTS * pixels * min(turns, samples)
    codes, moments = np.zeros(0, np.int64), np.zeros((0, MOMENTS), np.float32)
    lanes, rays = [], []
    for begin in range(0, samples, turns):
        part = range(begin, min(begin + turns, samples))
        while (taken := trace(part, room).read()) is None:
            room *= 2
        (lane, cell, gains), (lane_outside, escaped) = taken
        lanes.append(lane_outside)
        escaped[:, WEIGHT] /= samples
        rays.append(escaped)
        gain = gains[:, :1] * np.float32(albedo / (4 * np.pi * samples))
        away = gains[:, 1:] - centres_mm[cell].astype(np.float32)
        found = _summed(lane.astype(np.int64) * cells + cell, gain * np.hstack([np.ones_like(gain), away]))
        codes, moments = _summed(np.concatenate([codes, found[0]]), np.concatenate([moments, found[1]]))
    owner = np.concatenate(lanes)
    order = np.argsort(owner, kind="stable")
    first = np.searchsorted(owner[order], np.arange(pixels + 1))
    columns = codes[:, None] % cells + cells * np.arange(MOMENTS)
    rows = np.repeat(codes // cells, MOMENTS)
    response = sp.csr_matrix((moments.ravel(), (rows, columns.ravel())), shape=(pixels, MOMENTS * cells))
    return RecordedPaths(
        response=response,
        rays=mi.Float(np.concatenate(rays)[order].ravel()),
        first=mi.UInt32(first.astype(np.uint32)),
        owner=owner[order].astype(np.uint32),
        samples=samples,
    )


def _summed(codes: npt.NDArray[np.int64], values: npt.NDArray[np.float32]) -> tuple[Any, Any]:
    """Codes in order, each once, and the sums of the values that had it."""
    order = np.argsort(codes, kind="stable")
    codes = codes[order]
    starts = np.flatnonzero(np.diff(codes, prepend=-1))
    return codes[starts], np.add.reduceat(values[order], starts)
