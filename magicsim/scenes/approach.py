"""Frames in which nothing touches the block: what changes beside the untouched sensor, from recorded camera paths.

The block's geometry is that of the anchor, so its carefully traced paths serve: only the light pass is done anew, and
the rays that left the block are followed to what stands outside.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.scenes.anchor import Anchor
from magicsim.scenes.backend import mi
from magicsim.scenes.cached_light import cell_slopes
from magicsim.scenes.finish import Finish
from magicsim.scenes.light_field import LightField, total
from magicsim.scenes.names import FLASHLIGHT
from magicsim.scenes.outside import Outside
from magicsim.scenes.path_starts import MirroredStarts
from magicsim.scenes.recorded_paths import RecordedPaths, record_paths
from magicsim.scenes.rig import Rig
from magicsim.scenes.view import View
from magicsim.scenes.window import Window

Array = npt.NDArray[np.float64]
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


def recorded(scene: Any, *, seed: int, samples: int) -> RecordedPaths:
    """The camera paths of an untouched sensor.

    Args:
        scene: The loaded scene, with nothing before the block.
        seed: Random stream of the camera.
        samples: Paths of each pixel.
    """
    integrator = scene.integrator()
    columns, rows = (int(size) for size in scene.sensors()[0].film().size())
    return record_paths(
        lambda part, room: integrator.record(scene, part, samples=samples, seed=seed, capacity=room),
        pixels=columns * rows,
        centres_mm=integrator.centres_mm(scene),
        albedo=integrator.media.infill.albedo,
        samples=samples,
    )


def try_out(scene: Any, outside: Outside, finish: Finish, *, seed: int) -> None:
    """Compiles what a frame with such things outside needs, at a negligible number of samples.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        finish: Surface of the object.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    names = [FLASHLIGHT] if outside.object is None else list(integrator.shares(scene, outside))
    field = total(list(integrator.light_fields(scene, dict.fromkeys(names, 64), seed=seed, outside=outside).values()))
    paths = recorded(scene, seed=seed, samples=1)
    pixel = np.zeros(1, np.uint32)
    paths.seen_outside(outside, field.irradiance, finish, pixel)
    if outside.object is not None and finish.specular > 0:
        up = mi.Ray3f(mi.Point3f(0, 0, 0), mi.Vector3f(0, 0, 1))
        integrator.follow(scene, outside, MirroredStarts.of(mi.UInt32(0), up, mi.Float(1)), field, finish, seed=seed)


def light_outside(scene: Any, outside: Outside, anchor: Anchor, *, seed: int) -> LightField:
    """Light in the block and on the object, anchored.

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there. A flashlight alone reflects nothing: it adds light, and leaves that of the strips.
        anchor: The untouched sensor.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    particles = integrator.shares(scene, outside)
    if outside.object is None:
        added = integrator.light_fields(scene, {FLASHLIGHT: particles[FLASHLIGHT]}, seed=seed, outside=outside)
        return total([integrator.darkness(scene, outside), *anchor.careful.values(), *added.values()])
    fields = integrator.light_fields(scene, particles, seed=seed, outside=outside)
    for name in fields.keys() & anchor.careful.keys():
        fields[name] = fields[name].anchored(anchor.cheap[name], anchor.careful[name], integrator.counts, None)
    return total([integrator.darkness(scene, outside), *fields.values()])


def seen_beside_anchor(
    scene: Any, outside: Outside, paths: RecordedPaths, anchor: Anchor, finish: Finish, window: Window, *, samples: int,
    seed: int,
) -> Array:  # fmt: skip
    """Radiance of the ideal image's window less that of the untouched sensor, shape (rows, columns, 3).

    Args:
        scene: The loaded scene, with nothing before the block.
        outside: What stands there.
        paths: Of the untouched sensor.
        anchor: The untouched sensor.
        finish: Surface of the object.
        window: Part of the ideal image.
        samples: Paths of each pixel that a mirror sends on, about.
        seed: Of the frame.
    """
    integrator = scene.integrator()
    field = light_outside(scene, outside, anchor, seed=seed)
    change = field.fluence - np.sum([careful.fluence for careful in anchor.careful.values()], axis=0)
    slopes = cell_slopes(change, integrator.centres_mm(scene), integrator.counts)
    columns, rows = (int(size) for size in scene.sensors()[0].film().size())
    pixels = window.of(np.arange(columns * rows, dtype=np.uint32).reshape(rows, columns)).ravel()
    seen = paths.glow(change, slopes, pixels) + paths.seen_outside(outside, field.irradiance, finish, pixels)
    seen += paths.mirrored(
        outside, finish, pixels, lambda starts: integrator.follow(scene, outside, starts, field, finish, seed=seed),
        samples=samples, seed=seed,
    )  # fmt: skip
    return np.asarray(seen.reshape(window.rows, window.columns, 3))
