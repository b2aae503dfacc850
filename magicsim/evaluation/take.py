"""Takes: what one simulated episode shows before the camera, kept on disk so that it is rendered once.

Noise and exposure come afterwards, so that other sensor noise and other seeds of it cost no rendering. A take's file is
named after a hash of everything that decides its content; it appears whole or not at all, so a run that was cut off
goes on where it stopped.
"""

import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from magicsim.arrays import FloatImage
from magicsim.config.named_files import config_digest
from magicsim.config.program import program_key
from magicsim.folder import result_file
from magicsim.light.records.untouched_store import shared_states
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.plan import plan_scene
from magicsim.simulation.sensor import Sensor, room_radiance
from magicsim.simulation.stream import RenderedState, stream_states

TAKE_FORMAT = 2
"""Raised with every change of the file's content."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Take:
    """An episode before the camera. All arrays but `radiance` and `room` have one entry a frame, references first."""

    radiance: npt.NDArray[np.float32]
    """States that look different, shape (states, rows, columns, 3); the untouched sensor first."""
    room: npt.NDArray[np.float32]
    """What the room's light makes of the untouched image, shape (rows, columns, 3); empty where nothing asks for it."""
    state: npt.NDArray[np.int32]
    """Which of them a frame shows."""
    is_reference: npt.NDArray[np.bool_]
    gap_mm: npt.NDArray[np.float64]
    """NaN without an object."""
    force_n: npt.NDArray[np.float64]
    """Size of the contact force [N]."""
    flashlight: npt.NDArray[np.bool_]


def take_key(scene: SceneConfig) -> str:
    """Hash of everything that decides a take: the scene, the files that it names, and the program."""
    program = program_key(activate_variant())
    content = {"format": TAKE_FORMAT, "program": program, "scene": scene.model_dump(mode="json")}
    return config_digest(content)[:24]


def read_take(path: Path) -> Take:
    """Reads what `write_take` wrote."""
    with path.open("rb") as file, np.load(file, allow_pickle=False) as content:
        return Take(**{name: content[name] for name in Take.__slots__})


def write_take(path: Path, take: Take) -> None:
    """Writes a take; the file appears whole or not at all."""
    arrays = {name: getattr(take, name) for name in Take.__slots__}
    with result_file(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)
        file.flush()
        os.fsync(file.fileno())


logger = logging.getLogger(__name__)


def cached_take(scene: SceneConfig, cache: Path) -> Take:
    """The take of a scene from the cache, or simulated and put there."""
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
    """All states of a scene, every one that looks different rendered once."""
    sensor = Sensor.for_scene(scene, untouched=shared_states())
    untouched = sensor.render(UNTOUCHED, sensor.rest)
    frames = list(stream_states(sensor, plan_scene(scene), untouched))
    return assembled(frames, lambda each: each.radiance, first=untouched[0], room=room_radiance(sensor, untouched[0]))


def assembled(
    frames: Sequence[RenderedState],
    look: Callable[[RenderedState], FloatImage],
    *,
    first: FloatImage | None = None,
    room: FloatImage | None = None,
) -> Take:
    """A take of rendered states in order; those that share a radiance are looked at once.

    `look` gives the radiance that the take is to hold of a state; `first` comes before all others and is not looked at
    again; `room` is the untouched image by the room's light alone: all of shape (rows, columns, 3).
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
