"""What something outside changes of the room's light in the untouched block: particles that it meets, and no others.

Particles that enter the block before they meet anything go where they went without the object, so the noise of those is
that of the untouched sensor, and neighbouring places of an object differ by the few particles that meet it or not.
"""

from typing import Any

import numpy as np

from magicsim.light.backend import dr
from magicsim.light.records.untouched import Untouched
from magicsim.light.transport.light_field import LightField
from magicsim.light.transport.light_pass import FIXED_POINT, Tracks
from magicsim.light.transport.light_starts import LightStarts, Sent, chunks
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.streams import ROOM_BACK, SEEDS_PER_RENDER
from magicsim.light.world.names import ENVIRONMENT
from magicsim.light.world.outside import Outside


def room_change(world: LitWorld, outside: Outside, cheap: Untouched, *, seed: int) -> LightField:
    """Light of the room with something outside less that without; on the object all that arrives there.

    Args:
        world: The scene with nothing before the block.
        outside: What stands there, an object among it.
        cheap: The untouched sensor with the particles and random numbers of the frame, its room's light taken down.
        seed: Of the frame.
    """
    count = cheap.particles[ENVIRONMENT]
    first, *around = world.sent(ENVIRONMENT, count, seed=seed, outside=outside)
    gone = np.zeros(count, bool)
    added, lost = [], []
    for chunk in chunks([first]):
        starts = LightStarts.emitted(chunk)
        kept = dr.compress(_is_kept_out(world, outside, starts))
        if len(kept):
            gone[chunk[0].first + np.array(kept)] = True
            blocked = starts.some(kept)
            lost.append(world.light_pass(blocked))
            added.append(world.light_pass(blocked, outside=outside))
    added.extend(_beside(world, outside, around))
    assert cheap.room is not None
    seen = cheap.room.met(outside, seed=SEEDS_PER_RENDER * seed + ROOM_BACK, gone=gone)
    if seen is not None:
        added.append(world.light_pass(seen, outside=outside))
    return _difference(world, outside, added, lost, count)


def _is_kept_out(world: LitWorld, outside: Outside, starts: LightStarts) -> Any:
    """Which particles meet what stands outside before the sensor, mi.Bool."""
    there = outside.scene.ray_intersect_preliminary(starts.rays)
    dr.eval(there)  # a kernel on an NVIDIA GPU traces one scene
    block = world.scene.ray_intersect_preliminary(starts.rays)
    return there.is_valid() & (~block.is_valid() | (there.t < block.t))


def _beside(world: LitWorld, outside: Outside, parts: list[Sent]) -> list[Tracks]:
    """What the object sends on of light that would have met nothing else that counts."""
    tracks = []
    for chunk in chunks(parts):
        starts = LightStarts.emitted(chunk)
        meets = _is_kept_out(world, outside, starts) & (starts.brightest > 0)
        kept = dr.compress(meets)
        if len(kept):
            tracks.append(world.light_pass(starts.some(kept), outside=outside))
    return tracks


def _difference(world: LitWorld, outside: Outside, added: list[Tracks], lost: list[Tracks], count: int) -> LightField:
    dark, scale = world.darkness(outside), 1 / (FIXED_POINT * count)
    cells, body = dark.fluence.copy(), dark.body.copy()
    for sign, parts in ((1, added), (-1, lost)):
        for each in parts:
            cells += sign * scale * each.cells[0].astype(np.float64)
            body += sign * scale * each.body[0].astype(np.float64)
    landed = sum((each.landed[0].astype(np.float64) for each in added), np.zeros_like(dark.irradiance))
    return world.deposited(cells, body, scale * landed, outside)
