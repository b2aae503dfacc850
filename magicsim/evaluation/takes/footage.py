"""Labelled frames of one episode, rendered or recorded: the one form in which detectors and measures see them."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from magicsim.arrays import Array, Frame, Mask
from magicsim.camera.camera import Camera
from magicsim.camera.exposure import Lit
from magicsim.camera.stream import CameraStream, Instant
from magicsim.evaluation.cases import Case, list_cases
from magicsim.evaluation.suite import FIRST_PLACE, Role, SuiteConfig, SuiteNoise
from magicsim.evaluation.takes.simulated import cached_take
from magicsim.evaluation.takes.take import Take
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.judge.recording import Recording, read_recording

REST_STREAM = 0x3C5A96
"""Turns the seed of an episode into that of a stream at rest."""
RECORDED = "recorded"
"""Path, light and noise of a recording."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeTag:
    """Which episode it is. Episodes of one take share everything but the camera's noise."""

    take: str
    """`object/path/light/seed`, or a recording's name."""
    object: str
    role: Role
    path: str
    light: str
    noise: str
    place: str = FIRST_PLACE
    """Which sensor stands where."""

    @property
    def name(self) -> str:
        """Unique within a suite."""
        return f"{self.take}/{self.noise}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Labels:
    """Truth of the frames after the references; all arrays have shape (frames,)."""

    gap_mm: Array
    """NaN without an object, negative when pressed."""
    force_n: Array
    flashlight: Mask
    classes: tuple[FrameClass | None, ...]
    """By the rules of `magicsim.frame_class`; None where a frame is not scored."""

    @classmethod
    def of(cls, gap_mm: Array, force_n: Array, flashlight: Mask) -> "Labels":
        """Labels with their classes."""
        classes = tuple(
            classify_frame(gap_mm=None if np.isnan(gap) else float(gap), force_n=float(force), light_on=bool(light))
            for gap, force, light in zip(gap_mm, force_n, flashlight, strict=True)
        )
        return cls(gap_mm=gap_mm, force_n=force_n, flashlight=flashlight, classes=classes)


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
    labels: Labels
    images: Images
    frames_per_second: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ExposedTake:
    """Images of a take through a camera."""

    take: Take
    camera: Camera
    seed: int
    frames_per_second: float
    """Frame rate [1/s]."""
    lit: Lit = (True, True, True)
    """Whether any light of the sensor shines in red, green and blue."""

    def references(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(self.take.is_reference)

    def frames(self) -> Iterator[Frame]:
        """See `Images`."""
        return self._exposed(~self.take.is_reference)

    def at_rest(self, count: int) -> Iterator[Frame]:
        """So many frames of the untouched sensor, right after the references, with noise of their own.

        Args:
            count: How many.
        """
        take, rate = self.take, self.frames_per_second
        room = take.room if take.room.size else None
        stream = CameraStream.of(self.camera, take.radiance[0], self.lit, room=room)
        memory, first = stream.begin(rate), int(take.is_reference.sum())
        for index in range(first, first + count):
            at = Instant(seed=self.seed ^ REST_STREAM, index=index, time_s=index / rate, frames_per_second=rate)
            image, memory = stream.take(take.radiance[0], memory, at)
            yield image

    def _exposed(self, is_wanted: Mask) -> Iterator[Frame]:
        """The wanted frames; where frames depend on those before, the others are exposed on the way."""
        take, rate = self.take, self.frames_per_second
        room = take.room if take.room.size else None
        stream = CameraStream.of(self.camera, take.radiance[0], self.lit, room=room)
        memory = stream.begin(rate)
        for index in np.flatnonzero(is_wanted | bool(self.camera.history)).tolist():
            at = Instant(seed=self.seed, index=index, time_s=index / rate, frames_per_second=rate)
            image, memory = stream.take(take.radiance[take.state[index]], memory, at)
            if is_wanted[index]:
                yield image


def film_case(case: Case, suite: SuiteConfig, cache: Path) -> list[Footage]:
    """One footage for each sensor noise of a suite, from one take."""
    take = cached_take(case.scene, cache)
    scored = ~take.is_reference
    labels = Labels.of(take.gap_mm[scored], take.force_n[scored], take.flashlight[scored])
    return [
        Footage(
            tag=EpisodeTag(
                take=case.name,
                object=case.object,
                role=case.role,
                path=case.path,
                light=case.light,
                noise=noise.name,
                place=case.place,
            ),
            labels=labels,
            images=ExposedTake(
                take=take,
                camera=_camera(case.scene.rig.camera, noise),
                frames_per_second=suite.frames_per_second,
                lit=case.scene.rig.lit,
                seed=zlib.crc32(f"{suite.seed} {case.name} {noise.name}".encode()) & 0x7FFFFFFF,
            ),
            frames_per_second=suite.frames_per_second,
        )
        for noise in suite.noises
    ]


def read_recordings(suite: SuiteConfig) -> list[Footage]:
    """The recorded episodes of a suite.

    Raises:
        ConfigError: A folder or its table is not as `magicsim.judge.recording` says.
    """
    return [
        recorded_footage(
            read_recording(Path(each.folder)),
            EpisodeTag(
                take=each.name, object=each.object or each.name, role=each.role, path=RECORDED, light=RECORDED,
                noise=RECORDED,
            ),
            frames_per_second=suite.frames_per_second,
        )
        for each in suite.recordings
    ]  # fmt: skip


def recorded_footage(recording: Recording, tag: EpisodeTag, *, frames_per_second: float) -> Footage:
    """A recording as footage."""
    scored = recording.scored
    labels = Labels.of(recording.gap_mm[scored], recording.force_n[scored], recording.flashlight[scored])
    return Footage(tag=tag, labels=labels, images=recording, frames_per_second=frames_per_second)


def count_takes(suite: SuiteConfig) -> int:
    """Number of independent episodes of a suite."""
    return len(list_cases(suite)) + len(suite.recordings)


def _camera(camera: Camera, noise: SuiteNoise) -> Camera:
    changes = {key: value for key, value in noise.model_dump(exclude={"name"}).items() if value is not None}
    return camera.model_copy(update=changes)
