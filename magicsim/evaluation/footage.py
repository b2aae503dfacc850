"""Labelled frames of one episode, rendered or recorded: the one form in which detectors and measures see them."""

import json
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from magicsim.arrays import AnyArray, FloatImage, Frame, Mask
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import Lit
from magicsim.camera.stream import CameraStream, Instant
from magicsim.config.presets import preset_root
from magicsim.dataset.recipes.estimate import estimate_scene
from magicsim.evaluation.suite import QUICK, SuiteConfig, SuiteNoise
from magicsim.evaluation.take import Case, Take, cached_take, list_cases, take_key
from magicsim.judge.recorded import RecordedEpisode, read_recording
from magicsim.judge.tally import RECORDED, EpisodeLabels, EpisodeTag


class Images(Protocol):
    """Where an episode's images come from."""

    def references(self) -> Iterator[Frame]:
        """Frames of the untouched sensor, RGB, shape (rows, columns, 3)."""

    def frames(self) -> Iterator[Frame]:
        """The frames after them, in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Footage:
    """One labelled episode; its images are made or read when they are asked for."""

    tag: EpisodeTag
    labels: EpisodeLabels
    images: Images
    frames_per_second: float
    gamma: float | None = None
    """Exponent of the camera's tone curve; None where it is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExposedTake:
    """Images of a take through a camera."""

    take: Take
    camera: Camera
    seed: int
    frames_per_second: float
    lit: Lit = (True, True, True)
    """Whether any light of the sensor shines in red, green and blue."""
    passes: bool = False
    """Whether something passes in the room, of which a take holds its own frames alone."""

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(self.take.is_reference)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(~self.take.is_reference)

    def at_rest(self, count: int) -> Iterator[Frame]:
        """So many frames of the untouched sensor that follow the references, had nothing come."""
        first = int(self.take.is_reference.sum())
        begin = 0 if self.camera.history else first
        at_rest = ((index, self.take.radiance[0]) for index in range(begin, first + count))
        return (image for index, image in self._stream(at_rest) if index >= first)

    def _exposed(self, is_wanted: Mask) -> Iterator[Frame]:
        """The wanted frames; where frames depend on those before, the others are exposed on the way."""
        take = self.take
        places = np.flatnonzero(is_wanted | bool(self.camera.history)).tolist()
        frames = self._stream((index, take.radiance[take.state[index]]) for index in places)
        return (image for index, image in frames if is_wanted[index])

    def _stream(self, states: Iterable[tuple[int, FloatImage]]) -> Iterator[tuple[int, Frame]]:
        """Numbers and images of frames, each exposed after the one before."""
        take, rate = self.take, self.frames_per_second
        room = take.room if take.room.size else None
        stream = CameraStream.of(self.camera, take.radiance[0], self.lit, room=room)
        memory = stream.begin(rate)
        for index, radiance in states:
            at = Instant(seed=self.seed, index=index, time_s=index / rate, frames_per_second=rate)
            image, memory = stream.take(radiance, memory, at)
            yield index, image


def film_case(case: Case, suite: SuiteConfig, cache: Path) -> list[Footage]:
    """One footage for each sensor noise of a suite, from the cache or simulated."""
    return footage_of(case, cached_take(case.scene, cache), suite)


def footage_of(case: Case, take: Take, suite: SuiteConfig) -> list[Footage]:
    """One footage for each sensor noise of a suite, from one take."""
    scored = ~take.is_reference
    labels = EpisodeLabels.of(take.gap_mm[scored], take.force_n[scored], take.flashlight[scored])
    return [
        Footage(
            tag=EpisodeTag(
                take=case.name, object=case.object, role=case.role, path=case.path, light=case.light,
                noise=noise.name, place=case.place,
            ),
            labels=labels,
            images=ExposedTake(
                take=take, camera=_camera(case.scene.rig.camera, noise), frames_per_second=suite.frames_per_second,
                lit=case.scene.lit, passes=case.scene.rig.moving is not None,
                seed=zlib.crc32(f"{suite.seed} {case.name} {noise.name}".encode()) & 0x7FFFFFFF,
            ),
            frames_per_second=suite.frames_per_second,
            gamma=case.scene.rig.camera.gamma,
        )
        for noise in suite.noises
    ]  # fmt: skip


def read_recordings(suite: SuiteConfig) -> list[Footage]:
    """The recorded episodes of a suite, as `magicsim.judge.recorded` has them."""
    return [
        recorded_footage(
            read_recording(Path(each.folder)),
            EpisodeTag(
                take=each.name, object=each.object or each.name, role=each.role, path=RECORDED, light=RECORDED,
                noise=RECORDED, sensor=each.sensor,
            ),
            frames_per_second=suite.frames_per_second,
        )
        for each in suite.recordings
    ]  # fmt: skip


def recorded_footage(recording: RecordedEpisode, tag: EpisodeTag, *, frames_per_second: float) -> Footage:
    """A recording as footage."""
    return Footage(tag=tag, labels=recording.labels, images=recording, frames_per_second=frames_per_second)


def _camera(camera: Camera, noise: SuiteNoise) -> Camera:
    changes = {key: value for key, value in noise.model_dump(exclude={"name"}).items() if value is not None}
    return camera.model_copy(update=changes)


def foretold_s(suite: SuiteConfig, cache: Path, cores: int) -> tuple[int, int, float]:
    """Takes to render, takes that are kept, and the time that the first need [s], within a factor of two or so."""
    cases = list_cases(suite)
    wanted = [case for case in cases if not (cache / f"{take_key(case.scene)}.npz").is_file()]
    seconds = sum(estimate_scene(case.scene).seconds(cores) for case in wanted)
    return len(wanted), len(cases) - len(wanted), seconds


REST_S = 10.0
"""Longest stream at rest of a quick evaluation [s]."""
MIDDLE = {"uint8": 128, "uint16": 32768}
"""Value of a pixel that does not differ from the untouched one, by the image's type."""
FINER = 8
"""Parts of a grey level in which the untouched state is kept."""
INDEX, UNTOUCHED, LIGHT = "index.json", "untouched.png", "light.png"


def quick_suite(suite: SuiteConfig) -> tuple[SuiteConfig, list[str]]:
    """A suite's standard condition alone, and what that leaves out."""
    blocks = [
        block.model_copy(update={"lights": block.lights[:1], "seeds": block.seeds[:1], "places": ()})
        for block in suite.episodes
        if block.lights[0] == suite.episodes[0].lights[0]
    ]
    rest = min(suite.rest_s, REST_S)
    quick = suite.model_copy(update={"episodes": tuple(blocks), "noises": suite.noises[:1], "rest_s": rest})
    kept = {case.name for case in list_cases(quick)}
    gone = [case.name for case in list_cases(suite) if case.name not in kept]
    left_out = [f"take {name}" for name in gone]
    left_out += [f"noise {noise.name}" for noise in suite.noises[1:]]
    if rest < suite.rest_s:
        left_out.append(f"{suite.rest_s - rest:g} of {suite.rest_s:g} s at rest")
    return quick, left_out


@dataclass(frozen=True, slots=True, kw_only=True)
class QuickSet:
    """Takes that come with the program."""

    folder: Path
    grey: float
    """Radiance of a grey level."""
    state: tuple[int, ...]
    """What each frame shows: the untouched state (0), one of the object's, or one of the flashlight's after those."""
    flashlight: tuple[bool, ...]
    takes: dict[str, dict[str, Any]]
    """By name: `file`, and `gap_mm` (null without an object) and `force_n` of each frame."""
    made_by: dict[str, str]

    def take(self, name: str, references: int) -> Take:
        """One take, with so many references before its frames."""
        entry, untouched = self.takes[name], _image(self.folder / UNTOUCHED).astype(np.float32) * (self.grey / FINER)
        images = (_image(self.folder / file) for file in (entry["file"], LIGHT))
        changes = [each.astype(np.float32) - MIDDLE[each.dtype.name] for each in images]
        states = untouched + self.grey * np.concatenate(changes).reshape(-1, *untouched.shape)
        count = references + len(self.state)
        at_rest = [np.nan] * references
        return Take(
            radiance=np.concatenate([untouched[None], states]).astype(np.float32), room=np.zeros(0, np.float32),
            state=np.array([0] * references + list(self.state), np.int32), is_reference=np.arange(count) < references,
            gap_mm=np.array([*at_rest, *(np.nan if each is None else each for each in entry["gap_mm"])], np.float64),
            force_n=np.array([0.0] * references + entry["force_n"], np.float64),
            flashlight=np.array([False] * references + list(self.flashlight), bool),
        )  # fmt: skip


def load_quick_set() -> QuickSet:
    """The set that comes with the program."""
    folder = preset_root() / "detectors" / QUICK
    return QuickSet(folder=folder, **json.loads((folder / INDEX).read_text(encoding="utf-8")))


def shipped_films(suite: SuiteConfig) -> list[list[Footage]]:
    """Footage of a quick suite's takes that come with the program."""
    shipped, cases = load_quick_set(), {each.name: each for each in list_cases(suite)}
    return [footage_of(cases[name], shipped.take(name, suite.references), suite) for name in shipped.takes]


def _image(path: Path) -> AnyArray:
    return np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
