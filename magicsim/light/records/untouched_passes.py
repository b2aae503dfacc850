"""Both passes in the untouched block: record what they meet and what leaves it, and follow what things send back."""

import numpy as np

from magicsim.arrays import Array
from magicsim.light.backend import dr, in_rows
from magicsim.light.records.recorded_paths import RecordedPaths, record_paths
from magicsim.light.records.untouched import Untouched
from magicsim.light.transport.light_field import LightField, total
from magicsim.light.transport.lit_world import LitWorld
from magicsim.light.transport.path_record import PathRecord, Regions
from magicsim.light.transport.path_starts import CameraStarts
from magicsim.light.transport.recorded_light import LightRecord, RecordedLight
from magicsim.light.transport.streams import LIGHT_BACK, SEEDS_PER_RENDER
from magicsim.light.world.loaded_scene import Outside
from magicsim.light.world.names import ENVIRONMENT

CAREFUL_PATTERN = 2**40
"""Number of the careful images' first pattern of pixel positions: their error is none of a frame's."""


def untouched(
    world: LitWorld, particles: dict[str, int], *, seed: int, samples: int, most: int, recorded: int,
    with_room: bool = False, regions: Regions | None = None,
) -> Untouched:  # fmt: skip
    """The untouched sensor, and what its camera paths and its light pass before they leave the block.

    Of the paths of each pixel `most` are recorded, all others only count in the image; of the particles of each strip
    `recorded` are taken down, and those of the room if asked for. Regions tell where paths met surfaces.
    """
    strips = {name: count for name, count in particles.items() if name != ENVIRONMENT}
    first = max(1, min(recorded, *strips.values())) if strips else 1
    record = LightRecord.empty(len(strips), first)
    fields = world.light_fields(strips, seed=seed, record=record)
    # Light of the room is kept apart: it may meet what stands outside before it meets the block.
    room = {name: count for name, count in particles.items() if name == ENVIRONMENT}
    room_record = LightRecord.empty(1, room[ENVIRONMENT]) if room and with_room else None
    fields |= world.light_fields(room, seed=seed, record=room_record)
    # The light of an opaque coat is no sum over elements, and no path serves another frame.
    most = 1 if world.elastomer.design.is_opaque else min(most, samples)
    pattern = seed if regions is not None else CAREFUL_PATTERN + seed
    paths = recorded_paths(world, seed=seed, pattern=pattern, samples=most, regions=regions)
    field = total([world.darkness(), *fields.values()])
    columns, rows = (int(size) for size in world.scene.sensors()[0].film().size())
    pixels = np.arange(columns * rows, dtype=np.uint32)
    if world.elastomer.design.is_opaque:
        image = in_rows(world.gather_pixels(field, pixels, samples=samples, seed=seed, pattern=pattern), np.float32)
    else:
        image = paths.direct + paths.glow(world.elements(field), pixels)
        if samples > most:
            # The first points of the pattern are the recorded ones.
            starts = CameraStarts.of(
                world.scene.sensors()[0], samples=samples, pixels=pixels, pattern=pattern, part=range(most, samples)
            )
            others = in_rows(world.camera_pass(field, starts, stream=SEEDS_PER_RENDER * seed))
            image = (most * image + others) / samples
    return Untouched(
        fields=fields,
        particles=dict(particles),
        paths=paths,
        light=RecordedLight.of(*record.read(), first),
        room=RecordedLight.of(*room_record.read(), room[ENVIRONMENT]) if room_record is not None else None,
        held_mm3=world.held_mm3(),
        image=image.reshape(rows, columns, 3).astype(np.float32),
    )


def recorded_paths(
    world: LitWorld, *, seed: int, samples: int, pattern: int = 0, regions: Regions | None = None
) -> RecordedPaths:
    """The camera paths of an untouched sensor, with the points of a pattern in each pixel."""
    dark, sensor = world.darkness(), world.scene.sensors()[0]
    pixels = int(np.prod(np.array(sensor.film().size())))

    def trace(part: range, room: int) -> tuple[PathRecord, Array]:
        record = PathRecord.empty(room, len(part), lanes=pixels, regions=regions)
        starts = CameraStarts.of(
            sensor, samples=samples, pixels=np.arange(pixels, dtype=np.uint32), pattern=pattern, part=part
        )
        seen = world.camera_pass(dark, starts, stream=SEEDS_PER_RENDER * seed, record=record)
        dr.eval(seen, record)
        return record, in_rows(seen)

    centres = world.elements(dark).centres_mm
    return record_paths(trace, pixels=pixels, centres_mm=centres, samples=samples, regions=regions)


def follow_light(world: LitWorld, outside: Outside, light: RecordedLight, *, seed: int) -> LightField:
    """What the object sends back of recorded light: more fluence in the block, and irradiance on itself."""
    starts = light.met(outside, seed=SEEDS_PER_RENDER * seed + LIGHT_BACK)
    if starts is None:
        return world.darkness(outside)
    return world.brought(world.light_pass(starts, outside=outside), 1 / (light.steps * light.particles), outside)
