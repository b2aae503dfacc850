"""Simulates one scene up to the camera, or takes what was simulated of it before."""

import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from magicsim.arrays import FloatImage
from magicsim.evaluation.takes.take import Take, read_take, take_key, write_take
from magicsim.light.records.untouched_states import shared_states
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor, room_radiance
from magicsim.simulation.stream import RenderedState, stream_states

logger = logging.getLogger(__name__)


def cached_take(scene: SceneConfig, cache: Path) -> Take:
    """The take of a scene from the cache, or simulated and put there.

    Raises:
        MagicsimError: The scene cannot be simulated, or the cache cannot be written.
    """
    path = cache / f"{take_key(scene)}.npz"
    if path.is_file():
        try:
            return read_take(path)
        except (OSError, ValueError, KeyError, BadZipFile) as error:
            logger.warning("%s is damaged (%s) and is made again", path.name, error)
    take = film_take(scene)
    write_take(path, take)
    return take


def film_take(scene: SceneConfig) -> Take:
    """All states of a scene, every one that looks different rendered once.

    Raises:
        MagicsimError: The design, a deformation or an image is not valid.
    """
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    untouched = sensor.made(UNTOUCHED, sensor.rest)
    frames = list(stream_states(sensor, plan_scene(scene), untouched))
    return assembled(frames, lambda each: each.radiance, first=untouched[0], room=room_radiance(sensor, untouched[0]))


def assembled(
    frames: Sequence[RenderedState],
    look: Callable[[RenderedState], FloatImage],
    *,
    first: FloatImage | None = None,
    room: FloatImage | None = None,
) -> Take:
    """A take of rendered states; those that share a radiance are looked at once.

    Args:
        frames: In order.
        look: Radiance that the take is to hold of a state, shape (rows, columns, 3).
        first: A radiance that comes before all others and is not looked at again, shape (rows, columns, 3).
        room: What the room's light makes of the untouched image, shape (rows, columns, 3).
    """
    images, place = ([], {}) if first is None else ([first], {id(first): 0})
    for each in frames:
        if id(each.radiance) not in place:
            place[id(each.radiance)] = len(images)
            images.append(look(each))
    gaps = [each.state.gap_mm for each in frames]
    return Take(
        radiance=np.stack(images).astype(np.float32),
        room=np.zeros(0, np.float32) if room is None else room,
        state=np.array([place[id(each.radiance)] for each in frames], np.int32),
        is_reference=np.array([each.is_reference for each in frames], bool),
        gap_mm=np.array([np.nan if gap is None else gap for gap in gaps], np.float64),
        force_n=np.array([np.linalg.norm(each.deformation.force_n) for each in frames], np.float64),
        flashlight=np.array([each.state.flashlight for each in frames], bool),
    )
