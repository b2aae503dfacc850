"""Frames of one recording in order, each with its time and its labels."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import islice
from pathlib import Path

import numpy as np

from magicsim.config.presets import is_file, is_folder
from magicsim.dataset.real.description import Description, RealSource, RecordingSource
from magicsim.dataset.real.form import brightened, formed, timed_frames
from magicsim.dataset.real.labels import LabelTable, Row, at_time, check_times, force_size, nothing, read_labels
from magicsim.detectors.frame import Frame
from magicsim.detectors.source import IMAGE_SUFFIXES, read_image, read_source
from magicsim.detectors.video import VIDEO_SUFFIXES
from magicsim.errors import ConfigError, FrameError

MOST_REFERENCES = 30
"""Frames of the untouched sensor that detectors take by default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RealFrame:
    """One recorded frame."""

    name: str
    image: Frame
    """RGB in the form that the description asks for, shape (rows, columns, 3)."""
    labels: Row
    """See `magicsim.dataset.real.labels`; `time_s` is NaN where it is not known."""
    is_reference: bool


@dataclass(frozen=True)
class RecordedSequence:
    """One recording: what it holds is read when it is asked for."""

    real: RealSource
    number: int
    """Place in the description."""

    @property
    def description(self) -> Description:
        """How its frames and labels are read."""
        return self.real.description

    @property
    def source(self) -> RecordingSource:
        """What the description says of it."""
        return self.description.recordings[self.number]

    @property
    def frames_path(self) -> Path:
        """Folder of images, or video."""
        return self.real.path(self.source.frames)

    @property
    def field(self) -> str:
        """What messages call it."""
        return f"recordings[{self.number}]"

    @cached_property
    def is_video(self) -> bool:
        """Whether it is one file.

        Raises:
            ConfigError: It is neither a folder nor a video.
        """
        path = self.frames_path
        if is_folder(path):
            return False
        if is_file(path) and path.suffix.lower() in VIDEO_SUFFIXES:
            return True
        msg = f"{self.field}.frames = '{path}' is not allowed: must be a folder of images or a video"
        raise ConfigError(msg)

    @cached_property
    def labels(self) -> LabelTable | None:
        """Rows of its CSV file; None without one.

        Raises:
            ConfigError: It cannot be read, or a video's rows have no times.
        """
        if self.source.labels is None:
            return None
        labels = read_labels(self.real.path(self.source.labels), self.description, needs_images=not self.is_video)
        if self.is_video:
            check_times(labels)
        return labels

    @cached_property
    def entries(self) -> tuple[tuple[Path, Row], ...]:
        """Image files and labels of a folder, in order of the labels, or of their names where there are none.

        Raises:
            ConfigError: A row names an image that is not there, or there is none at all.
        """
        folder = self.frames_path
        if self.labels is None:
            names = sorted(each for each in folder.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES)
            entries = tuple((each, nothing()) for each in names)
        else:
            entries = tuple(
                (_image_file(folder, row["image"], f"{self.labels.path}, line {line}"), row)
                for line, row in enumerate(self.labels.rows, 2)
            )
        if not entries:
            msg = f"{self.field}.frames: folder '{folder}' holds no image ({', '.join(IMAGE_SUFFIXES)})"
            raise ConfigError(msg)
        return entries

    @property
    def files(self) -> tuple[Path, ...]:
        """Everything that it is read from, in order."""
        frames = (self.frames_path,) if self.is_video else tuple(path for path, _ in self.entries)
        extra = self._untouched_files()
        return frames + extra + ((self.labels.path,) if self.labels is not None else ())

    @cached_property
    def reference_numbers(self) -> frozenset[int]:
        """Which of its own frames are references, counted from 0.

        Raises:
            ConfigError: No force is small enough, or the labels of a video do not tell.
        """
        source = self.source
        if source.untouched_first is not None:
            return frozenset(range(source.untouched_first))
        if source.untouched_below_n is not None:
            return self._least_forces(source.untouched_below_n)
        if self.description.columns.is_reference is not None and not self.is_video and source.untouched is None:
            return frozenset(number for number, (_, row) in enumerate(self.entries) if row["is_reference"])
        return frozenset()

    @cached_property
    def episodes(self) -> tuple[str, ...]:
        """What its labels call its episodes, in order; one empty text where they tell none apart."""
        if self.labels is None or "episode" not in self.labels.known:
            return ("",)
        rows = self.labels.rows if self.is_video else tuple(row for _, row in self.entries)
        return tuple(dict.fromkeys(row["episode"] for row in rows))

    def references(self) -> Iterator[RealFrame]:
        """Frames of the untouched sensor, at most 30; none where nobody says which those are."""
        if self.source.untouched is None:
            yield from islice(self._frames(lambda number, _: number in self.reference_numbers), MOST_REFERENCES)
            return
        for path in self._untouched_files()[:1]:
            reading = read_source(path.parent if is_folder(self.real.path(self.source.untouched)) else path)
            try:
                for each in islice(reading, MOST_REFERENCES):
                    image = formed(each.image, self.description.frames, name=each.name)
                    yield RealFrame(name=each.name, image=image, labels=nothing(), is_reference=True)
            finally:
                reading.close()

    def scored(self, episode: str = "", *, every: int = 1) -> Iterator[RealFrame]:
        """The other frames of an episode in order, or only each `every`th."""

        def wanted(number: int, labels: Row) -> bool:
            is_here = len(self.episodes) == 1 or labels["episode"] == episode
            return number % every == 0 and is_here and number not in self.reference_numbers

        yield from self._frames(wanted)

    def _frames(self, wanted: Callable[[int, Row], bool]) -> Iterator[RealFrame]:
        """Some of its own frames, told by their number and labels."""
        form, gain = self.description.frames, self.source.gain
        for number, (name, read, labels) in enumerate(self._read()):
            if not wanted(number, labels):
                continue
            is_reference = number in self.reference_numbers
            image = formed(read(), form, name=name)
            image = image if is_reference else brightened(image, gain)
            yield RealFrame(name=name, image=image, labels=labels, is_reference=is_reference)

    def _read(self) -> Iterator[tuple[str, Callable[[], Frame], Row]]:
        """Name, what reads the image, and labels of every frame."""
        if not self.is_video:
            rate = self.description.frames_per_second
            for number, (path, row) in enumerate(self.entries):
                time_s = number / rate if math.isnan(row["time_s"]) and rate is not None else row["time_s"]
                yield path.name, partial(read_image, path), row | {"time_s": time_s}
            return
        for number, (time_s, image) in enumerate(timed_frames(self.frames_path)):
            labels = nothing()
            if self.labels is not None:
                labels = at_time(self.labels, time_s + self.source.offset_s, most_gap_s=self.description.most_gap_s)
            yield f"{self.frames_path.name}#{number}", partial(_itself, image), labels | {"time_s": time_s}

    def _least_forces(self, most_n: float) -> frozenset[int]:
        where = f"{self.field}.untouched_below_n = {most_n:g} is not allowed"
        if self.is_video or self.labels is None or "force_n" not in self.labels.known:
            msg = f"{where}: it needs a folder of images and labels with columns.force_n"
            raise ConfigError(msg)
        sizes = np.array([force_size(row["force_n"]) for _, row in self.entries])
        order = np.argsort(np.where(np.isnan(sizes), np.inf, sizes), kind="stable")[:MOST_REFERENCES]
        numbers = frozenset(int(place) for place in order if sizes[place] < most_n)
        if not numbers:
            msg = f"{where}: the least force is {np.nanmin(sizes) if not np.isnan(sizes).all() else math.nan:.3g} N"
            raise ConfigError(msg)
        return numbers

    def _untouched_files(self) -> tuple[Path, ...]:
        if self.source.untouched is None:
            return ()
        path = self.real.path(self.source.untouched)
        if is_folder(path):
            return tuple(sorted(each for each in path.iterdir() if each.suffix.lower() in IMAGE_SUFFIXES))
        if not is_file(path):
            msg = f"{self.field}.untouched = '{path}' is not allowed: must be a folder of images, an image or a video"
            raise ConfigError(msg)
        return (path,)


def sequences_of(real: RealSource) -> list[RecordedSequence]:
    """Every recording of a description."""
    return [RecordedSequence(real, number) for number in range(len(real.description.recordings))]


def check_size(frame: Frame, size: tuple[int, int], name: str) -> None:
    """Refuses a frame of another size than those before.

    Args:
        frame: Shape (rows, columns, 3).
        size: Rows and columns of those before.
        name: What the message calls it.

    Raises:
        FrameError: It says what to set.
    """
    if frame.shape[:2] != size:
        msg = (
            f"frame '{name}' has {frame.shape[1]} x {frame.shape[0]} pixels, those before it {size[1]} x {size[0]}; "
            f"set frames.size_px = [{size[1]}, {size[0]}], and frames.crop_px where their shapes differ"
        )
        raise FrameError(msg)


def _itself(image: Frame) -> Frame:
    return image


def _image_file(folder: Path, name: str, where: str) -> Path:
    """File of a row, whose ending may be missing."""
    candidates = [folder / name]
    if Path(name).suffix.lower() not in IMAGE_SUFFIXES:
        candidates += [folder / f"{name}{ending}" for ending in IMAGE_SUFFIXES]
    for path in candidates:
        if name and is_file(path):
            return path
    msg = f"{where}: image '{name}' is not in folder '{folder}'; columns.image names the column of file names"
    raise ConfigError(msg)
