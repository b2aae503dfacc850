"""Both passes in the untouched block with things outside: record what leaves it, and follow what they send back."""

from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.backend import dr
from magicsim.scenes.finish import Finish
from magicsim.scenes.integrator import SEEDS_PER_RENDER, FluenceIntegrator
from magicsim.scenes.inventory import emitter_of
from magicsim.scenes.light_field import LightField
from magicsim.scenes.light_pass import FIXED_POINT
from magicsim.scenes.light_starts import emitter_chunks
from magicsim.scenes.outside import Outside
from magicsim.scenes.path_record import PathRecord
from magicsim.scenes.path_starts import CameraStarts, MirroredStarts
from magicsim.scenes.recorded_light import FLOATS, LightRecord, RecordedLight
from magicsim.scenes.shapes import lights
from magicsim.scenes.window import Window

Array = npt.NDArray[np.float64]
LIGHT_BACK, MIRRORED = SEEDS_PER_RENDER - 2, SEEDS_PER_RENDER - 1
"""Random streams of light and of camera paths that something outside sends on; the others are the lights'."""


def record_camera(scene: Any, part: range, *, samples: int, seed: int, capacity: int) -> PathRecord:
    """What some camera paths of every pixel pass.

    Args:
        scene: The loaded scene, with nothing before the block.
        part: Numbers of the samples of each pixel that are traced.
        samples: Of a pixel in all.
        seed: Random stream.
        capacity: Number of segments that there is room for.
    """
    integrator, sensor = scene.integrator(), scene.sensors()[0]
    record, window = PathRecord.empty(capacity, len(part)), Window.whole(*(int(size) for size in sensor.film().size()))
    starts = CameraStarts.of(sensor, samples=samples, window=window, pattern=0, part=part)
    seen = integrator.camera_pass(
        scene, integrator.inventory.shapes(scene), integrator.darkness(scene), starts, integrator.finish,
        stream=SEEDS_PER_RENDER * seed, record=record,
    )  # fmt: skip
    dr.eval(seen, record)
    return record


def follow_camera(
    scene: Any, outside: Outside, starts: MirroredStarts, field: LightField, finish: Finish, *, seed: int
) -> Array:
    """Radiance that paths meet from where something outside has mirrored them on, shape (paths, 3).

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        starts: Of the paths.
        field: Light in the block and on the object.
        finish: Surface of the object.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    shapes, stream = integrator.inventory.shapes(scene, outside), SEEDS_PER_RENDER * seed + MIRRORED
    seen = integrator.camera_pass(scene, shapes, field, starts, finish, stream=stream)
    return np.array(seen, np.float64).T


def record_light(scene: Any, particles: int, *, seed: int) -> RecordedLight:
    """What leaves the untouched block of the light of all strips.

    Args:
        scene: The loaded scene, with nothing before the block.
        particles: Of each strip.
        seed: Of the light.
    """
    integrator, escapes = scene.integrator(), [np.zeros((0, FLOATS), np.float32)]
    for name in lights(scene):
        if name in integrator.off:
            continue
        stream, emitter = integrator.stream(scene, name, seed), emitter_of(scene, name)
        for starts in emitter_chunks(emitter, particles, seed=stream, inside=name in integrator.inside):
            record = LightRecord.empty(starts.particles)
            integrator.light_pass(scene, integrator.inventory.shapes(scene), starts, stream=stream, record=record)
            escapes.append(record.read())
    return RecordedLight.of(np.concatenate(escapes), particles)


def follow_light(scene: Any, outside: Outside, light: RecordedLight, *, seed: int) -> LightField:
    """What the object sends back of recorded light: more fluence in the cells, and irradiance on itself.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        light: What leaves the block.
        seed: Of the frame.
    """
    integrator: FluenceIntegrator = scene.integrator()
    inventory, starts, dark = integrator.inventory, light.met(outside), integrator.darkness(scene, outside)
    if starts is None:
        return dark
    shapes = inventory.shapes(scene, outside)
    tracks = integrator.light_pass(scene, shapes, starts, stream=SEEDS_PER_RENDER * seed + LIGHT_BACK)
    scale = 1 / (FIXED_POINT * light.particles)
    landed = np.asarray(tracks.landed.reshape(-1, 3) * scale, np.float64)
    return LightField(
        fluence=np.asarray(tracks.cells.reshape(-1, 3) * scale / inventory.volumes_mm3(scene), np.float64),
        body=dark.body,
        irradiance=inventory.irradiance(scene, shapes, landed),
    )
