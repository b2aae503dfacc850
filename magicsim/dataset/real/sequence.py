"""Frames of one recording in order, each with its time and its labels."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import islice
from pathlib import Path

import numpy as np

from magicsim.config.presets import is_file, is_folder
from magicsim.dataset.real.description import Description, RealSource, RecordingSource
from magicsim.dataset.real.form import brightened, clock_start_s, formed
from magicsim.dataset.real.labels import (
    Entry,
    LabelTable,
    RealTruth,
    Row,
    at_time,
    check_times,
    in_order,
    nothing,
    read_labels,
    size_of_force,
    truth_of,
)
from magicsim.detectors.frame import Frame
from magicsim.detectors.picture import IMAGE_SUFFIXES, read_image
from magicsim.detectors.source import image_files, image_path, open_source, read_source
from magicsim.detectors.video import VIDEO_SUFFIXES, Shot
from magicsim.errors import ConfigError, FrameError
from magicsim.frame_class import NEAR_MIN_MM, FrameClass

SAMPLED = 12
"""Frames of a recording that are looked at, at least where there are so many, and less than twice of it."""
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """What a recording holds."""

    rows: tuple[Row, ...]
    """Labels of all its own frames in order, references among them."""
    samples: tuple[RealFrame, ...]
    """Frames that are no references, spread over it."""


@dataclass(frozen=True)
class RecordedSequence:
    """One recording: what it holds is read when it is asked for."""

    real: RealSource
    number: int
    """Place in the description."""
    remarks: dict[str, None] = dataclasses.field(default_factory=dict, compare=False)
    """What was said of its files so far, in order."""

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

    def remark(self, line: str) -> None:
        """Takes what a reader says of its files, once each."""
        self.remarks.setdefault(f"{self.field}: {line}")

    @cached_property
    def is_film(self) -> bool:
        """Whether it is one file, whose labels are found by their time; `ConfigError` unless a folder or pictures."""
        path = self.frames_path
        if is_folder(path):
            return False
        if is_file(path) and path.suffix.lower() in (*VIDEO_SUFFIXES, *IMAGE_SUFFIXES):
            return True
        raise ConfigError(
            f"{self.field}.frames = '{path}' is not allowed: must be a folder of images or a video, or an image file "
            "of several pictures"
        )

    @cached_property
    def is_video(self) -> bool:
        """Whether it is a video, which has times of its own."""
        return self.is_film and self.frames_path.suffix.lower() in VIDEO_SUFFIXES

    @cached_property
    def start_s(self) -> float:
        """What is added to times from the first frame of a film to get those of its labels [s]."""
        return (clock_start_s(self.frames_path) if self.is_video else 0.0) + self.source.offset_s

    @cached_property
    def labels(self) -> LabelTable | None:
        """Rows of its CSV file; None without one. `ConfigError` where a film's rows or frames have no times."""
        if self.source.labels is None:
            return None
        labels = read_labels(self.real.path(self.source.labels), self.description, needs_images=not self.is_film)
        if self.is_film:
            check_times(labels)
            if not self.is_video and self.description.frames_per_second is None:
                raise ConfigError(
                    f"frames_per_second is missing: it gives the pictures of '{self.frames_path}' times, by which they "
                    "get labels"
                )
        return labels

    @cached_property
    def entries(self) -> tuple[Entry, ...]:
        """Image files and labels of a folder with labels, in the order in which they were taken; none without labels.

        `ConfigError` where a row names an image that is not there or that another one names, or their order is not
        clear.
        """
        if self.labels is None or self.is_film:
            return ()
        lines: dict[Path, int] = {}
        entries = []
        for row in self.labels.rows:
            where, name = f"{self.labels.path}, line {row['line']}", row["image"]
            path = image_path(self.frames_path, name)
            if path is None:
                raise ConfigError(
                    f"{where}: image '{name}' is not in folder '{self.frames_path}'; columns.image names the column of "
                    "file names"
                )
            if path in lines:
                raise ConfigError(f"{where}: image '{name}' stands in line {lines[path]} too; must have one row")
            lines[path] = row["line"]
            entries.append((path, row))
        return in_order(entries, self.labels.path, self.remark)

    @property
    def files(self) -> tuple[Path, ...]:
        """Everything that it is read from, in order."""
        frames: tuple[Path, ...] = (self.frames_path,)
        if not self.is_film:
            frames = tuple(path for path, _ in self.entries) or tuple(image_files(self.frames_path, self.remark))
        extra = self._untouched_files()
        return frames + extra + ((self.labels.path,) if self.labels is not None else ())

    @cached_property
    def survey(self) -> "Survey":
        """The labels of all its own frames, and some frames."""
        rows: list[Row] = []
        samples: list[RealFrame] = []
        every, scored = 1, 0
        for number, (shot, row) in enumerate(self._shots()):
            rows.append(row)
            if number in self.reference_numbers:
                continue
            if scored % every == 0:
                samples.append(self._frame(number, shot, row))
            scored += 1
            if len(samples) == 2 * SAMPLED:
                samples, every = samples[::2], 2 * every
        return Survey(rows=tuple(rows), samples=tuple(samples))

    @cached_property
    def reference_numbers(self) -> frozenset[int]:
        """Which of its own frames are references, counted from 0; `ConfigError` where nothing tells that."""
        source, found = self.source, frozenset[int]()
        if source.untouched_first is not None:
            found = frozenset(range(source.untouched_first))
        elif source.untouched_below_n is not None:
            found = self._least_forces(source.untouched_below_n)
        elif self.description.columns.is_reference is not None and source.untouched is None:
            found = frozenset(number for number, (_, row) in enumerate(self._shots()) if row["is_reference"])
        if len(found) > MOST_REFERENCES:
            self.remark(f"the first {MOST_REFERENCES} of {len(found)} untouched frames serve as references, no others")
        return found

    def begin_s(self, episode: str) -> float:
        """Least known time of an episode's frames, its own references among them [s]; NaN where none is known."""
        here = [
            row["time_s"] for number, row in enumerate(self.survey.rows)
            if len(self.episodes) == 1 or number in self.reference_numbers or row["episode"] == episode
        ]  # fmt: skip
        return min((each for each in here if not math.isnan(each)), default=math.nan)

    @cached_property
    def episodes(self) -> tuple[str, ...]:
        """What the labels of its frames call its episodes, in order; one empty text where they tell none apart."""
        if self.labels is None or "episode" not in self.labels.known:
            return ("",)
        return tuple(dict.fromkeys(row["episode"] for row in self.survey.rows if row["is_there"])) or ("",)

    def references(self) -> Iterator[RealFrame]:
        """At most 30 frames of the untouched sensor, none where none are named; `ConfigError` where one is touched."""
        if self.source.untouched is None:
            for each in islice(self._frames(lambda number, _: number in self.reference_numbers), MOST_REFERENCES):
                self._check_reference(each)
                yield each
            return
        if not self._untouched_files():
            return
        with closing(read_source(self.real.path(self.source.untouched), self.remark)) as reading:
            for read in islice(reading, MOST_REFERENCES):
                image = formed(read.image, self.description.frames, name=read.name)
                yield RealFrame(name=read.name, image=image, labels=nothing(), is_reference=True)

    def scored(self, episode: str = "") -> Iterator[RealFrame]:
        """The other frames of an episode in order."""

        def wanted(number: int, labels: Row) -> bool:
            is_here = len(self.episodes) == 1 or labels["episode"] == episode
            return is_here and number not in self.reference_numbers

        yield from self._frames(wanted)

    def truth(self, labels: Row, *, name: str = "frame") -> RealTruth:
        """The state that labels of one of its frames tell; raises what `magicsim.dataset.real.labels.truth_of` does."""
        known = self.labels.known if self.labels is not None else frozenset[str]()
        return truth_of(labels, self.description.truth, known, name=name)

    def _check_reference(self, frame: RealFrame) -> None:
        rules, source, labels = self.description.truth, self.source, frame.labels
        felt_n = max(rules.contact_n, source.untouched_below_n or 0.0)
        known = self.labels.known if self.labels is not None else frozenset[str]()
        truth = truth_of(labels, rules.model_copy(update={"contact_n": felt_n}), known, name=frame.name)
        if truth.contact or truth.frame_class is FrameClass.CONTACT or truth.gap_mm <= -NEAR_MIN_MM:
            size = size_of_force(labels, felt_n)
            told = f" of {size:.3g} N" if size > felt_n else ""
            raise ConfigError(
                f"{self.field}: reference '{frame.name}' is a contact{told} by its labels: references show the "
                "untouched sensor; subtract what it shows then, or raise truth.contact_n"
            )

    def _frames(self, wanted: Callable[[int, Row], bool]) -> Iterator[RealFrame]:
        """Some of its own frames, told by their number and labels."""
        for number, (shot, labels) in enumerate(self._shots()):
            if wanted(number, labels):
                yield self._frame(number, shot, labels)

    def _frame(self, number: int, shot: Shot, labels: Row) -> RealFrame:
        is_reference = number in self.reference_numbers
        image = formed(shot.read(), self.description.frames, name=shot.name)
        image = image if is_reference else brightened(image, self.source.gain)
        return RealFrame(name=shot.name, image=image, labels=labels, is_reference=is_reference)

    def _shots(self) -> Iterator[tuple[Shot, Row]]:
        """Every own frame before it is decoded, and its labels, in order."""
        rate, is_video = self.description.frames_per_second, self.is_video
        if self.entries:
            for number, (path, row) in enumerate(self.entries):
                time_s = number / rate if math.isnan(row["time_s"]) and rate is not None else row["time_s"]
                yield Shot(name=path.name, read=partial(read_image, path, self.remark)), row | {"time_s": time_s}
            return
        before = -math.inf
        with closing(open_source(self.frames_path, self.remark)) as shots:
            for number, shot in enumerate(shots):
                time_s = shot.time_s
                if not is_video:
                    time_s = number / rate if rate is not None else math.nan
                elif time_s < before or (number == 1 and time_s == 0):
                    raise FrameError(
                        f"video '{self.frames_path}': frame {number} has no time; write it with time stamps, or save "
                        "its images"
                    )
                before, labels = time_s, nothing()
                if self.labels is not None:
                    labels = at_time(self.labels, time_s + self.start_s, most_gap_s=self.description.most_gap_s)
                yield shot, labels | {"time_s": time_s}

    def _least_forces(self, most_n: float) -> frozenset[int]:
        where = f"{self.field}.untouched_below_n = {most_n:g} is not allowed"
        if self.is_film or self.labels is None or "force_n" not in self.labels.known:
            raise ConfigError(f"{where}: it needs a folder of images and labels with columns.force_n")
        sizes = np.array([size_of_force(row, self.description.truth.contact_n) for _, row in self.entries])
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
            return tuple(image_files(path, self.remark))
        if not is_file(path):
            raise ConfigError(
                f"{self.field}.untouched = '{path}' is not allowed: must be a folder of images, an image or a video"
            )
        return (path,)


def sequences_of(real: RealSource) -> list[RecordedSequence]:
    """Every recording of a description."""
    return [RecordedSequence(real, number) for number in range(len(real.description.recordings))]


def check_size(frame: Frame, size: tuple[int, int], name: str) -> None:
    """Refuses (`FrameError`) a frame of another size, rows and columns, than those before, and says what to set."""
    if frame.shape[:2] == size:
        return
    now, before = f"{frame.shape[1]} x {frame.shape[0]}", f"{size[1]} x {size[0]}"
    advice = f"set frames.size_px = [{size[1]}, {size[0]}], and frames.crop_px where their shapes differ"
    if frame.shape[:2] == size[::-1]:
        advice = "one of them is turned, or was as its file says: turn it before, or set frames.size_px"
    raise FrameError(f"frame '{name}' has {now} pixels, those before it {before}; {advice}")
