"""Image of one frame from recorded camera paths: what light and things outside change of the untouched sensor's image.

A path serves as long as no surface that it meets inside the block has moved. What it then meets outside, and the light
that it gathers on its way, are those of the frame. Where a press has moved something on a pixel's way, its paths are
traced anew, with the random numbers of recorded ones: what both differ by is the change (`anchored_image`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter

from magicsim.arrays import Array, FloatImage, Numbers
from magicsim.light.backend import dr
from magicsim.light.records.untouched import Untouched
from magicsim.light.records.untouched_passes import follow_camera
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_pass import FIXED_POINT, sum_tracks
from magicsim.light.transport.light_starts import ROUND_OBJECT, LightStarts, Sent, chunks
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.streams import PASSING, PASSING_ON_OBJECT, SEEDS_PER_RENDER
from magicsim.light.world.names import ENVIRONMENT
from magicsim.light.world.outside import Outside
from magicsim.light.world.passing_light import PassingLight, PassingPart

SIGNS = (1.0, -1.0)
SPREAD_CELLS = 1.5
"""Standard deviation of that Gaussian [cells]: below a scattering free path of 3 mm."""
MIRRORED_PER_SAMPLE = 3
"""Paths that a glossy object sends on, for each camera sample: its highlights are small and bright."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """What a frame shows to paths through the untouched block."""

    world: LitWorld
    """The scene with nothing before the block."""
    outside: Outside
    """What stands there."""
    field: LightField
    """Light in the block and on the object."""
    samples: int
    """Camera samples of each pixel that are traced on where the object mirrors."""
    seed: int
    passing: PassingLight | None = None
    """What passes, in its place, if what it changes is looked at: `field` is then its change of the light."""

    def through(self, rest: Untouched, pixels: Numbers) -> Array:
        """Radiance of some pixels by the paths of one record, or its change by what passes, shape (pixels, 3)."""
        paths, world, outside, field = rest.paths, self.world, self.outside, self.field
        finish, passing = world.content.object_finish, self.passing
        if passing is None:
            own = own_field(world, rest)
            change = LightField(
                fluence=field.fluence - own.fluence, body=field.body - own.body, irradiance=own.irradiance
            )
            seen = paths.glow(world.elements(change), pixels)
            seen += paths.seen_outside(world.inventory.environment, outside, field.irradiance, finish, pixels)
        else:
            seen = paths.glow(world.elements(field), pixels)
            seen += paths.seen_of_room(passing, pixels)
            if outside.object is not None or outside.flashlight is not None:
                seen += paths.seen_outside(None, outside, field.irradiance, finish, pixels, room=passing)
        seen += paths.mirrored(
            outside, finish, pixels, lambda starts: follow_camera(
                world, outside, starts, field, seed=self.seed, room=passing
            ), samples=MIRRORED_PER_SAMPLE * self.samples, seed=self.seed,
        )  # fmt: skip
        return np.asarray(seen if passing is not None else np.maximum(rest.image.reshape(-1, 3)[pixels] + seen, 0))


def own_field(world: LitWorld, rest: Untouched) -> LightField:
    """Light of all lights of the untouched sensor."""
    return total([world.darkness(), *rest.fields.values()])


def room_part(world: LitWorld, rest: Untouched, pixels: Numbers) -> FloatImage:
    """What the room's light makes of some pixels of the untouched image, shape (pixels, 3).

    The share that it has of what recorded paths see, of the image that has more of them.
    """
    own, room = own_field(world, rest), rest.fields[ENVIRONMENT]
    paths, light = rest.paths, replace(own, fluence=room.fluence, body=room.body)
    whole = paths.direct[pixels] + paths.glow(world.elements(own), pixels)
    seen = paths.glow(world.elements(light), pixels) + paths.seen_of_room(world.inventory.environment, pixels)
    share = np.divide(seen, whole, out=np.zeros_like(seen), where=whole > 0).clip(0, 1)
    return np.asarray(share * rest.image.reshape(-1, 3)[pixels], np.float32)


def passing_light_change(
    world: LitWorld, outside: Outside, light: PassingLight, rest: LightField, *, particles: int, seed: int
) -> LightField:
    """Change of the light in the untouched block and on what stands before it; values of either sign.

    Noise is spread over neighbouring cells, see `spread`.
    """
    tracks = [
        world.light_pass(starts.some(kept), lights=len(SIGNS), outside=outside)
        for chunk in chunks(_sent(world, outside, light, particles, seed))
        if len(kept := dr.compress((starts := LightStarts.emitted(chunk)).brightest > 0))
    ]
    if not tracks:
        return world.darkness(outside)
    found, scale = sum_tracks(tracks), 1 / (FIXED_POINT * particles)
    # What the positive part left less what the negative part did.
    parts = [each.astype(np.float64) for each in (found.cells, found.body, found.landed)]
    cells, body, landed = (scale * (plus - minus) for plus, minus in parts)
    change, voxels = world.deposited(cells, body, landed, outside), world.voxel_counts
    body = spread(body, rest.body, voxels) if voxels is not None else body
    return replace(change, fluence=spread(change.fluence, rest.fluence, world.counts), body=body)


def spread(change: Array, level: Array, counts: tuple[int, int, int]) -> Array:
    """A noisy change of light, spread over neighbouring cells in proportion to the light that is there; its sum stays.

    Each cell's change goes to its neighbours by a Gaussian's weights times their level: what changes light from cell to
    cell is the grid, and that of the untouched sensor is known.
    """
    around = _neighbours(level, counts)
    share = np.divide(change, around, out=np.zeros_like(change), where=around > 0)
    return np.where(around > 0, level * _neighbours(share, counts), change)


def _neighbours(values: Array, counts: tuple[int, int, int]) -> Array:
    """Gaussian mean over neighbouring cells with weights that are the same both ways, cells in x-fastest order."""
    nx, ny, nz = counts
    grid = values.reshape(nz, ny, nx, 3)
    return gaussian_filter(grid, (SPREAD_CELLS,) * 3 + (0.0,), mode="reflect").reshape(-1, 3)


def _sent(world: LitWorld, outside: Outside, light: PassingLight, particles: int, seed: int) -> list[Sent]:
    sent = []
    for place, sign in enumerate(SIGNS):
        parts = ((1.0, PASSING), (ROUND_OBJECT, PASSING_ON_OBJECT))
        for beam, (share, stream) in zip(world.inventory.beams(outside), parts, strict=False):
            count = max(1, round(share * particles))
            part, numbers = PassingPart(light, sign), SEEDS_PER_RENDER * seed + stream
            sent.append(Sent(part, 0, count, numbers, False, place, beam, particles / count))
    return sent
