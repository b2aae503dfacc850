"""Labelled frames of one episode, rendered or recorded: the one form in which detectors and measures see them."""

import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from magicsim.arrays import FloatImage, Frame, Mask
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import Lit
from magicsim.camera.stream import CameraStream, Instant
from magicsim.dataset.recipes.estimate import estimate_scene
from magicsim.evaluation.suite import SuiteConfig, SuiteNoise
from magicsim.evaluation.take import Case, Take, cached_take, list_cases, take_key
from magicsim.judge.recorded import RecordedEpisode, read_recording
from magicsim.judge.tally import RECORDED, EpisodeLabels, EpisodeTag

REST_STREAM = 0x3C5A96
"""Turns the seed of an episode into that of a stream at rest."""


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

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(self.take.is_reference)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(~self.take.is_reference)

    def at_rest(self, count: int) -> Iterator[Frame]:
        """So many frames of the untouched sensor, right after the references, with noise of their own."""
        first = int(self.take.is_reference.sum())
        at_rest = ((index, self.take.radiance[0]) for index in range(first, first + count))
        return (image for _, image in self._stream(at_rest, self.seed ^ REST_STREAM))

    def _exposed(self, is_wanted: Mask) -> Iterator[Frame]:
        """The wanted frames; where frames depend on those before, the others are exposed on the way."""
        take = self.take
        places = np.flatnonzero(is_wanted | bool(self.camera.history)).tolist()
        frames = self._stream(((index, take.radiance[take.state[index]]) for index in places), self.seed)
        return (image for index, image in frames if is_wanted[index])

    def _stream(self, states: Iterable[tuple[int, FloatImage]], seed: int) -> Iterator[tuple[int, Frame]]:
        """Numbers and images of frames, each exposed after the one before."""
        take, rate = self.take, self.frames_per_second
        room = take.room if take.room.size else None
        stream = CameraStream.of(self.camera, take.radiance[0], self.lit, room=room)
        memory = stream.begin(rate)
        for index, radiance in states:
            at = Instant(seed=seed, index=index, time_s=index / rate, frames_per_second=rate)
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
                lit=case.scene.rig.lit,
                seed=zlib.crc32(f"{suite.seed} {case.name} {noise.name}".encode()) & 0x7FFFFFFF,
            ),
            frames_per_second=suite.frames_per_second,
            gamma=case.scene.rig.camera.gamma,
        )
        for noise in suite.noises
    ]  # fmt: skip


def read_recordings(suite: SuiteConfig) -> list[Footage]:
    """The recorded episodes of a suite.

    Raises:
        ConfigError: A folder or its table is not as `magicsim.judge.recorded` says.
    """
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


def count_takes(suite: SuiteConfig) -> int:
    """Number of independent episodes of a suite."""
    return len(list_cases(suite)) + len(suite.recordings)


def _camera(camera: Camera, noise: SuiteNoise) -> Camera:
    changes = {key: value for key, value in noise.model_dump(exclude={"name"}).items() if value is not None}
    return camera.model_copy(update=changes)


def foretold_s(suite: SuiteConfig, cache: Path, cores: int) -> tuple[int, int, float]:
    """Takes to render, takes that are kept, and the time that the first need [s], within a factor of two or so."""
    cases = list_cases(suite)
    wanted = [case for case in cases if not (cache / f"{take_key(case.scene)}.npz").is_file()]
    seconds = sum(estimate_scene(case.scene).seconds(cores) for case in wanted)
    return len(wanted), len(cases) - len(wanted), seconds
