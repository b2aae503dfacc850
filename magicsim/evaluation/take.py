"""The episodes of a suite: as scenes, one for every combination that its tables name, and as takes.

A take is what one simulated episode shows before the camera, kept on disk so that it is rendered once. Noise and
exposure come afterwards, so that other sensor noise and other seeds of it cost no rendering. A take's file is named
after a hash of everything that decides its content; it appears whole or not at all, so a run that was cut off goes on
where it stopped.
"""

import logging
import os
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from magicsim.arrays import FloatImage
from magicsim.config.named_files import config_digest
from magicsim.config.program import program_key
from magicsim.evaluation.suite import PathFrame, SuiteConfig, SuiteLight, SuiteObject, SuitePath, SuitePlace
from magicsim.folder import result_file
from magicsim.folder.kept import kept_takes
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.judge.tally import Role
from magicsim.light.variant import activate_variant
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import ContactSettings, Keyframe, OutputSettings, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.plan import plan_scene

if TYPE_CHECKING:
    from magicsim.simulation.stream import RenderedState


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One episode to simulate."""

    name: str
    """Unique within the suite: `object/path/light/seed`, and the place where it is not the first one."""
    object: str
    role: Role
    path: str
    light: str
    place: str
    scene: SceneConfig


def list_cases(suite: SuiteConfig) -> list[Case]:
    """All simulated episodes of a suite, in the order of its blocks; a combination named twice counts once."""
    objects = {each.name: each for each in suite.objects}
    paths = {each.name: each for each in suite.paths}
    lights = {each.name: each for each in suite.lights}
    places = {each.name: each for each in suite.places}
    sensors = {name: suite.sensor(each) for name, each in places.items()}
    cases: dict[str, Case] = {}
    for block in suite.episodes:
        where = block.places or (suite.places[0].name,)
        for place, seed, path, light, body in product(where, block.seeds, block.paths, block.lights, block.objects):
            case = _case(suite, places[place], sensors[place], objects[body], paths[path], lights[light], seed)
            cases.setdefault(case.name, case)
    return list(cases.values())


def _case(
    suite: SuiteConfig, place: SuitePlace, sensor: tuple[ElastomerDesign, Rig], body: SuiteObject, path: SuitePath,
    light: SuiteLight, seed: int,
) -> Case:  # fmt: skip
    shift = _jitter(suite, body.name, seed)
    keyframes = [_keyframe(each, body, shift) for each in path.frames]
    design, rig = sensor
    elsewhere = "" if place.name == suite.places[0].name else f"/{place.name}"
    return Case(
        name=f"{body.name}/{path.name}/{light.name}/{seed}{elsewhere}",
        object=body.name,
        role="held_out" if "held_out" in (body.role, place.role) else "training",
        place=place.name,
        path=path.name,
        light=light.name,
        scene=SceneConfig(
            schema_version=1, design=design, rig=rig, seed=seed, references=suite.references,
            frames_per_second=suite.frames_per_second, object=parse_object(body.object),
            contact=ContactSettings(friction=path.friction), render=suite.render, output=OutputSettings.nothing(),
            keyframes=tuple(Keyframe(**each) for each in _lit(keyframes, light)),
        ),
    )  # fmt: skip


def _jitter(suite: SuiteConfig, name: str, seed: int) -> tuple[float, float, float]:
    """Shift along x and y [mm] and twist [degrees] of an object, the same for all its paths and lights."""
    random = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    x, y, twist = (random.uniform(-1, 1, 3) * [suite.jitter_mm, suite.jitter_mm, suite.jitter_deg]).round(6).tolist()
    return x, y, twist


def _keyframe(each: PathFrame, body: SuiteObject, shift: tuple[float, float, float]) -> dict[str, Any]:
    light = {"flashlight": each.flashlight, "light_x_mm": each.light_x_mm}
    if each.gap_mm is None and each.press is None:
        return {"frame": each.frame, **light}
    gap = each.gap_mm if each.gap_mm is not None else -(each.press or 0.0) * body.press_mm
    x, y, twist = body.x_mm + shift[0] + each.x_mm, body.y_mm + shift[1] + each.y_mm, shift[2] + each.twist_deg
    return {"frame": each.frame, "gap_mm": gap, "x_mm": x, "y_mm": y, "twist_deg": twist, **light}


def _lit(keyframes: list[dict[str, Any]], light: SuiteLight) -> Iterator[dict[str, Any]]:
    """Keyframes with the light on, and moving, wherever the object is there."""
    held = [each["frame"] for each in keyframes if "gap_mm" in each]
    for each in keyframes:
        if not light.flashlight or "gap_mm" not in each:
            yield each
            continue
        share = (each["frame"] - held[0]) / max(1, held[-1] - held[0])
        place = light.from_x_mm + share * (light.to_x_mm - light.from_x_mm)
        yield each | {"flashlight": True, "light_x_mm": round(place, 9)}


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
    path, kept = cache / f"{take_key(scene)}.npz", kept_takes(cache)
    if path.is_file():
        kept.touch(path)
        try:
            return read_take(path)
        except (OSError, ValueError, KeyError, BadZipFile) as error:
            logger.warning("%s is damaged (%s) and is made again", path.name, error)
    take = film_take(scene)
    write_take(path, take)
    kept.shrink()
    return take


def film_take(scene: SceneConfig) -> Take:
    """All states of a scene, every one that looks different rendered once."""
    from magicsim.light.records.untouched import shared_states
    from magicsim.simulation.sensor import Sensor, room_radiance
    from magicsim.simulation.stream import stream_states

    sensor = Sensor.for_scene(scene, untouched=shared_states())
    untouched = sensor.render(UNTOUCHED, sensor.rest)
    frames = list(stream_states(sensor, plan_scene(scene), untouched))
    return assembled(frames, lambda each: each.radiance, first=untouched[0], room=room_radiance(sensor, untouched[0]))


def assembled(
    frames: "Sequence[RenderedState]",
    look: "Callable[[RenderedState], FloatImage]",
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
