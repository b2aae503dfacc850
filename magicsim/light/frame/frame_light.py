"""Light of one frame: that of the untouched sensor, and what object, outside lights and deformation change of it.

While nothing touches, what the object adds is traced from recorded light, and nothing else changes. A touched frame
has the light of just before contact, and where the object covers so much of the face that it may change it, traces its
particles anew: what they differ by from the same particles before contact is the change that counts, as far as it is
more than noise (`anchored_light`). So light is the same estimate on both sides of the first contact.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.backend import dr
from magicsim.light.frame.anchored_light import Expected, anchored_light, contact_share
from magicsim.light.records.untouched import Untouched
from magicsim.light.records.untouched_passes import follow_light
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.light_starts import FIXED_POINT, LightStarts, Sent, chunks
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.streams import ROOM_BACK, SEEDS_PER_RENDER
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.scenes.timeline import LightOrigin

LIFTED_MM = 2e-3
"""Gap of the last state before contact [mm]."""
LIFTED_DIGITS = 7
"""Decimals of the object's vertices there [mm], so that all depths of one press have the very same ones."""
CHANNELS = 3


def lifted(vertices: Array) -> Array:
    """The object's vertices moved back along z until it only just does not touch, shape (vertices, 3) [mm]."""
    return np.asarray(np.round(vertices - np.array([0.0, 0.0, vertices[:, 2].max() + LIFTED_MM]), LIFTED_DIGITS))


def free_light(
    world: LitWorld, outside: Outside, anchor: Untouched, control: Untouched, *, particles: int, seed: int
) -> LightField:
    """Light in the untouched block and on what stands before it."""
    # Nothing else is traced from a light.
    lamp = {FLASHLIGHT: particles} if outside.flashlight is not None else {}
    fields = world.light_fields(lamp, seed=seed, outside=outside)
    return total([_own_light(world, outside, anchor, control, seed=seed), *fields.values()])


@dataclass(frozen=True, kw_only=True)
class Before:
    """Light of strips and room in the last state before contact, which frames along one press share.

    A flashlight stands in its way there too, or the room would be brighter as soon as something touches.
    """

    world: LitWorld
    """The scene with nothing before the block."""
    placed: Callable[[], Outside]
    """Puts what stands before the block where it stood then; it may be somewhere else when the light is asked for."""
    rest: Untouched
    control: Untouched
    """The untouched sensor with the particles and random numbers of the frame."""
    seed: int

    @cached_property
    def anchor(self) -> LightField:
        """Light on the object and in the block as well as it is known."""
        return _own_light(self.world, self.placed(), self.rest, self.control, seed=self.seed)

    @cached_property
    def traced(self) -> LightField:
        """By the particles of the frame."""
        world, outside, control, seed = self.world, self.placed(), self.control, self.seed
        unseen = [replace(each, irradiance=np.zeros((1, CHANNELS))) for each in control.fields.values()]
        rest = total([world.darkness(), *unseen])
        back = [follow_light(world, outside, control.light, seed=seed)]
        if ENVIRONMENT in control.fields:
            back.append(room_change(world, outside, control, seed=seed))
        added = total(back)
        return replace(added, fluence=rest.fluence + added.fluence, body=rest.body + added.body)


def touched_light(
    world: LitWorld, before: Before, anchor: Untouched, contact: SurfaceMesh | None, *, least: float,
    particles: int, seed: int,
) -> tuple[LightField, LightOrigin]:  # fmt: skip
    """Light in the deformed block and on the object, and where it comes from.

    Below `least`, the expected relative change in the root mean square over the cells, the light before contact serves:
    each cell keeps its own. A body that scatters changes its light with its shape, and is always traced. Where nobody
    knows the contact, all changes that are found count.
    """
    shares = world.shares(particles)
    expected = None
    if contact is not None:  # what share of the light of each cell and voxel comes from it
        part, surface = world.body_part(), (contact.vertices, contact.faces)
        places = part.centres_mm if part is not None else np.zeros((1, 3))
        cells = contact_share(world.inventory.centres_mm(), *surface)
        expected = Expected(cells=cells, voxels=contact_share(places, *surface))
    if expected is not None and world.voxels is None and expected.size(before.anchor.fluence) < least:
        lamp = {name: count for name, count in shares.items() if name == FLASHLIGHT}
        return total([before.anchor, *world.light_fields(lamp, seed=seed).values()]), "before contact"
    fields = world.light_fields(shares, seed=seed)
    flashlight = fields.pop(FLASHLIGHT, None)
    now = total([world.darkness(), *fields.values()])
    growth = world.growth(anchor.held_mm3)
    states = zip(_by_channel(now), _by_channel(before.traced), _by_channel(before.anchor), strict=True)
    found = [
        anchored_light(one, traced, known, world.counts, world.voxel_counts, growth=growth, expected=expected)
        for one, traced, known in states
    ]
    anchored = replace(total(found), irradiance=now.irradiance)
    return total([anchored, *([flashlight] if flashlight is not None else [])]), "traced"


def _own_light(world: LitWorld, outside: Outside, anchor: Untouched, control: Untouched, *, seed: int) -> LightField:
    """Light of strips and room with something outside: the untouched sensor's, and what the object adds to it."""
    dark, counts, voxels = world.darkness(outside), world.counts, world.voxel_counts
    known = replace(total([world.darkness(), *anchor.fields.values()]), irradiance=dark.irradiance)
    lit = known
    if outside.object is not None:
        back = follow_light(world, outside, anchor.light, seed=seed)
        lit = total([known, back])
        lit = replace(anchored_light(lit, known, known, counts, voxels), irradiance=back.irradiance)
    if ENVIRONMENT not in anchor.fields or not outside.is_there:
        return lit
    traced, rest = (each.fields[ENVIRONMENT] for each in (control, anchor))
    change = room_change(world, outside, control, seed=seed)
    room = replace(traced, fluence=traced.fluence + change.fluence, body=traced.body + change.body)
    changed = anchored_light(room, traced, rest, counts, voxels)
    return LightField(
        fluence=lit.fluence + changed.fluence - rest.fluence,
        body=lit.body + changed.body - rest.body,
        irradiance=lit.irradiance + change.irradiance,
    )


def _by_channel(field: LightField) -> list[LightField]:
    """One field for each channel, dark in the others: what changes one colour of light need not change another."""
    dark = np.zeros((1, CHANNELS))
    return [
        LightField(fluence=field.fluence * only, body=field.body * only, irradiance=dark) for only in np.eye(CHANNELS)
    ]


def room_change(world: LitWorld, outside: Outside, control: Untouched, *, seed: int) -> LightField:
    """Light of the room with something outside less that without; on the object all that arrives there.

    Particles that enter the block before they meet anything go where they went without the object, so the noise of
    those is that of the untouched sensor, and neighbouring places of an object differ by the few particles that meet it
    or not.
    """
    count = control.particles[ENVIRONMENT]
    first, *around = world.sent(ENVIRONMENT, count, seed=seed, outside=outside)
    gone = np.zeros(count, bool)
    added, lost = [], []
    for numbers, blocked in kept_out(world, outside, [first]):
        gone[numbers] = True
        lost.append(world.light_pass(blocked))
        added.append(world.light_pass(blocked, outside=outside))
    # What the object sends on of light that would have met nothing else that counts.
    added.extend(world.light_pass(blocked, outside=outside) for _, blocked in kept_out(world, outside, around))
    assert control.room is not None
    seen = control.room.met(outside, seed=SEEDS_PER_RENDER * seed + ROOM_BACK, gone=gone)
    if seen is not None:
        added.append(world.light_pass(seen, outside=outside))
    dark, scale = world.darkness(outside), 1 / (FIXED_POINT * count)
    cells, body = dark.fluence.copy(), dark.body.copy()
    for sign, parts in ((1, added), (-1, lost)):
        for each in parts:
            cells += sign * scale * each.cells[0].astype(np.float64)
            body += sign * scale * each.body[0].astype(np.float64)
    landed = sum((each.landed[0].astype(np.float64) for each in added), np.zeros_like(dark.irradiance))
    return world.deposited(cells, body, scale * landed, outside)


def kept_out(world: LitWorld, outside: Outside, sent: Sequence[Sent]) -> Iterator[tuple[Index, LightStarts]]:
    """Particles that meet what stands outside before the sensor, with their numbers, as many at once as usual."""
    for chunk in chunks(sent):
        starts = LightStarts.emitted(chunk)
        there = outside.scene.ray_intersect_preliminary(starts.rays)
        dr.eval(there)  # a kernel on an NVIDIA GPU traces one scene
        block = world.scene.ray_intersect_preliminary(starts.rays)
        is_first = there.is_valid() & (~block.is_valid() | (there.t < block.t))
        kept = dr.compress(is_first & (starts.brightest > 0))
        if len(kept):
            yield chunk[0].first + np.array(kept, np.int64), starts.some(kept)
