"""Frames in which nothing touches the block: what changes beside the untouched sensor, from recorded camera paths.

The block's geometry is that of the anchor, so its carefully traced paths serve, of the camera and of the light: only
what left the block and meets something outside is traced on.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.anchor import Anchor
from magicsim.scenes.anchored_light import anchored_light
from magicsim.scenes.backend import mi
from magicsim.scenes.cached_light import cell_slopes
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.names import FLASHLIGHT
from magicsim.scenes.outside import Outside
from magicsim.scenes.path_starts import MirroredStarts
from magicsim.scenes.recorded_light import RecordedLight
from magicsim.scenes.recorded_paths import RecordedPaths, record_paths
from magicsim.scenes.rig import Rig
from magicsim.scenes.shapes import lights
from magicsim.scenes.untouched import Recorded
from magicsim.scenes.untouched_passes import follow_camera, follow_light, record_camera, record_light
from magicsim.scenes.view import View
from magicsim.scenes.window import Window

Array = npt.NDArray[np.float64]
TRIED = 4000
"""Particles that are enough to compile, and for some of them to meet what is near."""
MIRRORED_PER_SAMPLE = 3
"""Paths that a glossy object sends on, for each camera sample: its highlights are small and bright."""
CLEAR_MM = 1e-3
"""Least distance of the object from the contact face [mm]."""


def stands_free(view: View, rig: Rig, finish: Finish, integrator: Any, object_vertices: Array | None) -> bool:
    """Whether a view changes nothing that a recorded path depends on before it has left the block for good.

    Args:
        view: What to see.
        rig: What surrounds the block; light of the room reaches the camera past what stands outside.
        finish: Surface of the object.
        integrator: The estimator; followed collisions and a scattering body are not recorded.
        object_vertices: Of the object where it is, shape (vertices, 3) [mm]; None where there is none.
    """
    if not view.is_undeformed or max(rig.ambient) > 0 or integrator.followed or integrator.voxels is not None:
        return False
    if object_vertices is None:
        return True
    return not finish.is_ghost and bool(object_vertices[:, 2].max() < -CLEAR_MM)


def recorded_paths(scene: Any, *, seed: int, samples: int) -> RecordedPaths:
    """The camera paths of an untouched sensor.

    Args:
        scene: The loaded scene, with nothing before the block.
        seed: Random stream of the camera.
        samples: Paths of each pixel.
    """
    integrator = scene.integrator()
    columns, rows = (int(size) for size in scene.sensors()[0].film().size())
    return record_paths(
        lambda part, room: record_camera(scene, part, samples=samples, seed=seed, capacity=room),
        pixels=columns * rows,
        centres_mm=integrator.inventory.centres_mm(scene),
        albedo=integrator.media.infill.albedo,
        samples=samples,
    )


def recorded(scene: Any, *, seed: int, samples: int, particles: int) -> Recorded:
    """Camera paths and light of an untouched sensor.

    Args:
        scene: The loaded scene, with nothing before the block.
        seed: Random stream of both.
        samples: Paths of each pixel.
        particles: Of all strips together.
    """
    strips = max(1, len(lights(scene)))
    each = max(1, particles // strips)
    return Recorded(
        paths=recorded_paths(scene, seed=seed, samples=samples),
        light=record_light(scene, each, seed=seed),
    )


def try_out(scene: Any, outside: Outside, finish: Finish, *, seed: int) -> None:
    """Compiles what a frame with such things outside needs, at a negligible number of samples.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        finish: Surface of the object.
        seed: Of the frame.
    """
    integrator, pixel = scene.integrator(), np.zeros(1, np.uint32)
    field = integrator.darkness(scene, outside)
    known = recorded(scene, seed=seed, samples=1, particles=TRIED)
    if outside.flashlight is not None:
        field = total(list(integrator.light_fields(scene, {FLASHLIGHT: TRIED}, seed=seed, outside=outside).values()))
    known.paths.seen_outside(outside, field.irradiance, finish, pixel)
    if outside.object is not None:
        follow_light(scene, outside, known.light, seed=seed)
    if outside.object is not None and finish.specular > 0:
        up = mi.Ray3f(mi.Point3f(0, 0, 0), mi.Vector3f(0, 0, 1))
        follow_camera(scene, outside, MirroredStarts.of(mi.UInt32(0), up, mi.Float(1)), field, finish, seed=seed)


def strips_outside(scene: Any, outside: Outside, light: RecordedLight, anchor: Anchor, *, seed: int) -> LightField:
    """Light of the strips in the block and on the object: that of the untouched sensor, and what the object adds.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        light: Of the strips, that leaves the untouched sensor.
        anchor: The untouched sensor.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    careful = total([integrator.darkness(scene), *anchor.careful.values()])
    dark = integrator.darkness(scene, outside)
    if outside.object is None:
        return replace(careful, irradiance=dark.irradiance)
    back = follow_light(scene, outside, light, seed=seed)
    now = replace(careful, fluence=careful.fluence + back.fluence)
    careful = anchored_light({"": now}, {"": careful}, {"": careful}, integrator.counts, None)[""]
    return replace(careful, irradiance=back.irradiance)


def flashlight_outside(scene: Any, outside: Outside, *, seed: int) -> LightField:
    """Light of the flashlight in the block and on the object; it reflects nothing itself.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there, perhaps no flashlight.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    dark = integrator.darkness(scene, outside)
    # Nothing else is traced from a light.
    particles = {FLASHLIGHT: integrator.particles} if outside.flashlight is not None else {}
    return total([dark, *integrator.light_fields(scene, particles, seed=seed, outside=outside).values()])


def seen_outside(
    scene: Any,
    outside: Outside,
    paths: RecordedPaths,
    field: LightField,
    anchor: Anchor,
    finish: Finish,
    window: Window,
    *,
    samples: int,
    seed: int,
) -> Array:
    """Radiance of the ideal image's window less that of the untouched sensor, shape (rows, columns, 3).

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        paths: Camera paths of the untouched sensor.
        field: Light in the block and on the object.
        anchor: The untouched sensor, whose careful light is what the field differs from.
        finish: Surface of the object.
        window: Part of the ideal image.
        samples: Camera samples of each pixel.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    change = field.fluence - np.sum([careful.fluence for careful in anchor.careful.values()], axis=0)
    slopes = cell_slopes(change, integrator.inventory.centres_mm(scene), integrator.counts)
    columns, rows = (int(size) for size in scene.sensors()[0].film().size())
    pixels = window.of(np.arange(columns * rows, dtype=np.uint32).reshape(rows, columns)).ravel()
    seen = paths.glow(change, slopes, pixels) + paths.seen_outside(outside, field.irradiance, finish, pixels)
    seen += paths.mirrored(
        outside, finish, pixels, lambda starts: follow_camera(scene, outside, starts, field, finish, seed=seed),
        samples=MIRRORED_PER_SAMPLE * samples, seed=seed,
    )  # fmt: skip
    return np.asarray(seen.reshape(window.rows, window.columns, 3))
