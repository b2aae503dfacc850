"""Light of the facing finger's strips in this finger's block."""

from dataclasses import replace

import numpy as np

from magicsim.arrays import Array
from magicsim.light.backend import dr, mi
from magicsim.light.facing.glow import BELOW_MM, Glow, as_rays
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.light_pass import FIXED_POINT
from magicsim.light.transport.light_starts import LightStarts
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.streams import FACING, SEEDS_PER_RENDER
from magicsim.light.world.outside import Outside

HALF_TURN = np.array([-1.0, 1.0, -1.0])
"""Half a turn about y, which brings one finger's frame to the other's, applied to each coordinate."""


def facing_light(
    world: LitWorld, outside: Outside | None, glow: Glow, distance_mm: float, footprint_mm: tuple[float, float], *,
    seed: int, most: int,
) -> LightField:  # fmt: skip
    """What the facing finger's light brings to cells and body; what it brings to the object is gathered elsewhere.

    Args:
        world: The loaded scene.
        outside: What stands before the block in a scene of its own, or None where it is in the block's.
        glow: What leaves the facing finger.
        distance_mm: Of the contact faces [mm].
        footprint_mm: Size of the contact face along x and y [mm].
        seed: Of the frame.
        most: Particles that are traced at most.
    """
    dark = world.darkness(outside)
    chosen = arriving(glow.rays, distance_mm, footprint_mm, most=most)
    if not len(chosen):
        return dark
    rays, flux = as_rays(chosen)
    number = dr.arange(mi.UInt32, len(chosen))
    starts = LightStarts.escaped(number, rays, flux, dr.max(flux), seed=SEEDS_PER_RENDER * seed + FACING)
    tracks = world.light_pass(starts, outside=outside)
    fluence = tracks.cells[0] / FIXED_POINT / world.inventory.volumes_mm3()
    return replace(dark, fluence=fluence, body=tracks.body[0] / FIXED_POINT)


def arriving(rays: Array, distance_mm: float, footprint_mm: tuple[float, float], *, most: int) -> Array:
    """Rays of the facing finger that head for this one's face, in this one's frame, shape (rays, 9).

    An object between is met on the way, or sends on what would have missed; the latter is left to the light that is
    gathered on it.

    Args:
        rays: In the facing finger's frame, shape (rays, 9).
        distance_mm: Of the contact faces [mm].
        footprint_mm: Size of the contact face along x and y [mm].
        most: Every so manieth is taken, the brighter for it, where there are more.
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
