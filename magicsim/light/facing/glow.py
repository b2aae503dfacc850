"""What a sensor's contact face sends out, for another one that looks at it: light of its strips, and light sent back.

Both are measured on the untouched block: the light is what left it through its face when it was recorded; the
reflectance is the share of diffuse light on the face that comes out of it again.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from magicsim.arrays import Array
from magicsim.geometry.design import ElastomerDesign
from magicsim.light.backend import columns, dr, mi
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.light_starts import LightStarts, steps_of
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.recorded_light import LightRecord, RecordedLight
from magicsim.light.transport.streams import FACING, SEEDS_PER_RENDER, sequence
from magicsim.light.world.loaded_scene import Outside

HALF_TURN = np.array([-1.0, 1.0, -1.0])
"""Half a turn about y, which brings one finger's frame to the other's, applied to each coordinate."""
ASKED = 40_000
"""Particles that measure the reflectance: to 1 % of it where it is a quarter."""
BELOW_MM = 1e-3
"""Where they start below the face [mm]."""
BESIDE_MM = 0.05
"""How far above the face light still counts as coming out of it [mm]."""
SMOOTHED = 1.5
"""Standard deviation of the smoothing of the brightness over the face, in squares."""
LEAST = 0.02
"""Least reflectance that a face is given, so that its own light can be expressed by it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Glow:
    """What leaves a contact face, in that finger's own frame."""

    exitance: Array
    """Flux of the strips' light by area, shape (squares along x, squares along y, channels)."""
    reflectance: Array
    """Share of diffuse light that is sent back, shape (3,)."""
    rays: Array
    """Rays that leave: origin [mm], direction and flux, shape (rays, 9)."""

    @classmethod
    def of(cls, world: LitWorld, light: RecordedLight, design: ElastomerDesign, squares: tuple[int, int]) -> Self:
        """Glow of an untouched sensor."""
        rays = _out_of_face(light.escapes(), design)
        rays[:, 6:9] /= light.particles
        half = np.array(design.footprint_mm) / 2
        ends = [np.linspace(-end, end, count + 1) for end, count in zip(half, squares, strict=True)]
        flux = np.stack(
            [np.histogram2d(rays[:, 0], rays[:, 1], bins=ends, weights=rays[:, 6 + k])[0] for k in range(3)], -1
        )
        area = float(np.prod([2 * end / count for end, count in zip(half, squares, strict=True)]))
        exitance = gaussian_filter(flux / area, (SMOOTHED, SMOOTHED, 0), mode="reflect")
        return cls(exitance=exitance, reflectance=np.maximum(reflectance(world, design), LEAST), rays=rays)


def reflectance(world: LitWorld, design: ElastomerDesign, *, seed: int = 0) -> Array:
    """Share of diffuse light on the contact face that comes out of it again, shape (3,)."""
    start = mi.PCG32(size=1, initstate=dr.opaque(mi.UInt64, seed))
    u = sequence(dr.arange(mi.UInt32, ASKED), [start.next_uint32() for _ in range(4)])
    width, length = design.footprint_mm
    origin = mi.Point3f((u[0] - 0.5) * width, (u[1] - 0.5) * length, -BELOW_MM)
    rays = mi.Ray3f(origin, mi.warp.square_to_cosine_hemisphere(mi.Point2f(u[2], u[3])))
    weights = mi.Color3f(1.0) + dr.zeros(mi.Color3f, ASKED)
    starts = LightStarts.escaped(
        dr.arange(mi.UInt32, ASKED), rays, weights, mi.Float(1.0), seed=SEEDS_PER_RENDER * seed
    )
    record = LightRecord.empty(1, ASKED)
    world.light_pass(starts, record=record)
    return np.asarray(_out_of_face(record.read()[0], design)[:, 6:9].sum(0) / ASKED, np.float64)


def _out_of_face(escapes: npt.NDArray[np.float32], design: ElastomerDesign) -> Array:
    """Those that leave downwards through the face, of all that leave, shape (rays, 9)."""
    half = np.array(design.footprint_mm) / 2
    inside = (np.abs(escapes[:, :2]) <= half).all(1)
    rise = design.rise_mm(np.clip(escapes[:, :2].astype(np.float64), -half, half))
    chosen = inside & (escapes[:, 5] < 0) & (escapes[:, 2] <= rise + BESIDE_MM)
    return np.array(escapes[chosen, :9], np.float64)


def facing_light(
    world: LitWorld, outside: Outside | None, glow: Glow, distance_mm: float, footprint_mm: tuple[float, float], *,
    seed: int, most: int,
) -> LightField:  # fmt: skip
    """What the facing finger's light brings to cells and body; what it brings to the object is gathered elsewhere.

    `outside` is None where what stands before the block is in the block's own scene; `most` particles are traced at
    most.
    """
    dark = world.darkness(outside)
    chosen = arriving(glow.rays, distance_mm, footprint_mm, most=most)
    if not len(chosen):
        return dark
    column = [mi.Float(each) for each in columns(np.ascontiguousarray(chosen, np.float32))]
    rays, flux = mi.Ray3f(mi.Point3f(*column[:3]), mi.Vector3f(*column[3:6])), mi.Color3f(*column[6:])
    number = dr.arange(mi.UInt32, len(chosen))
    steps = steps_of(float(chosen[:, 6:].max()))
    starts = LightStarts.escaped(number, rays, flux, dr.max(flux), seed=SEEDS_PER_RENDER * seed + FACING, steps=steps)
    tracks = world.light_pass(starts, outside=outside)
    fluence = tracks.cells[0] / steps / world.inventory.volumes_mm3()
    return replace(dark, fluence=fluence, body=tracks.body[0] / steps)


def arriving(rays: Array, distance_mm: float, footprint_mm: tuple[float, float], *, most: int) -> Array:
    """Rays of the facing finger that head for this one's face, in this one's frame, shape (rays, 9).

    An object between is met on the way, or sends on what would have missed; the latter is left to the light that is
    gathered on it.

    Where there are more than `most`, every so manieth is taken, the brighter for it.
    """
    seen = rays.copy()
    seen[:, :3] *= HALF_TURN
    seen[:, :3] -= [0.0, 0.0, distance_mm]
    seen[:, 3:6] *= HALF_TURN
    seen[:, 2] = np.maximum(seen[:, 2], BELOW_MM - distance_mm)
    way = -seen[:, 2] / seen[:, 5]
    landing = seen[:, :2] + way[:, None] * seen[:, 3:5]
    found = seen[(np.abs(landing) <= np.array(footprint_mm) / 2).all(1)]
    stride = max(1, -(-len(found) // most))
    taken = found[::stride].copy()
    if len(taken):
        taken[:, 6:9] *= len(found) / len(taken)
    return taken
