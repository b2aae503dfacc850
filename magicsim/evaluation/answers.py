"""What a detector answers to the frames of an episode, checked, and kept beside the truth."""

import logging
import math
import time
from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256
from itertools import chain, islice
from typing import Any

import numpy as np

from magicsim.arrays import Array, Frame
from magicsim.detectors.offline import told_of_references
from magicsim.detectors.orientation import turned_against
from magicsim.detectors.verdict import FEATURES, Contact, Proximity
from magicsim.errors import ConfigError, unknown_choice
from magicsim.evaluation.detector import Detection, Detector, MakeDetector, tried
from magicsim.evaluation.footage import ExposedTake, Footage
from magicsim.judge.tally import FramesSeen, JudgedEpisode

_LOG = logging.getLogger(__name__)
DIGITS = 16
"""Hexadecimal digits by which frames are known again."""


def fitted(make: MakeDetector, references: Iterable[Frame], *, who: str) -> Detector:
    """A new detector that has learned the untouched sensor."""
    detector = make()
    tried(lambda: detector.fit(list(references)), f"detector '{who}': fit raised")
    return detector


def detection_of(detector: Detector, frame: Frame, *, who: str, which: str = "a frame") -> Detection:
    """A detector's answer to the next frame, checked."""
    said = tried(lambda: detector.step(frame), f"detector '{who}': step raised")
    if said is None:
        raise ConfigError(f"detector '{who}': step returned no answer to {which}; must be one for every frame")
    return check_detection(said, who=who)


def answers_to(
    frames: Iterable[Frame], references: Sequence[Frame], make: MakeDetector, take: str, *, who: str
) -> tuple[list[Detection], list[float]]:
    """Answers of a new detector to frames in order, and the time of each [s].

    Raises:
        ConfigError: It raises, an answer is missing or wrong, or it changes its references.
    """
    before = SeenFrames(references).seen.digest
    detector = fitted(make, references, who=who)
    said, spent = [], []
    for number, frame in enumerate(frames):
        start = time.perf_counter()
        said.append(detection_of(detector, frame, who=who, which=f"frame {number} of {take}"))
        spent.append(time.perf_counter() - start)
    if SeenFrames(references).seen.digest != before:
        raise ConfigError(f"detector '{who}' changes its references in {take}; must leave their pixels as they are")
    return said, spent


class SeenFrames:
    """What becomes known of frames while they pass."""

    def __init__(self, references: Iterable[Frame]) -> None:
        """Begins with references."""
        self._digest, self._levels = sha256(), list[float]()
        for each in references:
            self._add(each)

    def passed(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """The frames, each known once it has passed."""
        for each in frames:
            self._add(each)
            self._levels.append(float(each.mean()))
            yield each

    @property
    def seen(self) -> FramesSeen:
        """All that has passed so far."""
        return FramesSeen(digest=self._digest.hexdigest()[:DIGITS], levels=tuple(self._levels))

    def _add(self, frame: Frame) -> None:
        self._digest.update(str(frame.shape).encode())
        self._digest.update(np.ascontiguousarray(frame).data)


def check_detection(said: object, *, who: str) -> Detection:
    """A plug-in's answer, checked.

    Raises:
        ConfigError: One of the first four fields is missing, a verdict unknown, or a score not a finite number.
    """
    values: dict[str, Any] = {name: _number(getattr(said, name, None)) for name in FEATURES}
    for field in ("proximity", "contact", "approach", "touch"):
        if not hasattr(said, field):
            msg = f"detector '{who}': step returned {type(said).__name__} without {field}; must be like Detection"
            raise ConfigError(msg)
    for field, choices in (("proximity", Proximity), ("contact", Contact)):
        values[field] = getattr(said, field)
        if values[field] not in list(choices):
            raise ConfigError(f"detector '{who}': {unknown_choice(field, str(values[field]), choices)}")
    for field in ("approach", "touch"):
        values[field] = _number(getattr(said, field))
        if values[field] is None:
            msg = f"detector '{who}': {field} = {getattr(said, field)!r} is not allowed: must be a finite number"
            raise ConfigError(msg)
    return Detection(**values)


def _number(value: object) -> float | None:
    """A finite number, None where it is none."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


def judge_footage(footage: Footage, make: MakeDetector, *, who: str) -> JudgedEpisode:
    """Runs a new detector over an episode."""
    references, take = list(footage.images.references()), footage.tag.take
    frames = footage.images.frames()
    if not isinstance(footage.images, ExposedTake):  # frames that exist, which may be anybody's
        _ask_references(references, make, take, who=who)
        first = list(islice(frames, 1))
        for each in first:
            warn_of_turned(references, each, take)
        frames = chain(first, frames)
    passing = SeenFrames(references)
    said, spent = answers_to(passing.passed(frames), references, make, take, who=who)
    return JudgedEpisode(
        tag=footage.tag, labels=footage.labels, features=features_of(said),
        proximity=tuple(str(each.proximity) for each in said),
        contact=tuple(str(each.contact) for each in said),
        approach=np.array([each.approach for each in said], np.float64),
        touch=np.array([each.touch for each in said], np.float64),
        milliseconds=round(1e3 * float(np.median(spent)), 3) if spent else 0.0,
        frames_per_second=footage.frames_per_second, seen=passing.seen,
    )  # fmt: skip


def _ask_references(references: Sequence[Frame], make: MakeDetector, take: str, *, who: str) -> None:
    """Warns where the detector itself does not take its references for frames of the untouched sensor."""
    detector = fitted(make, references, who=who)
    said = [detection_of(detector, each, who=who) for each in references]
    for odd in told_of_references(references, [(each.proximity, each.contact) for each in said]):
        _LOG.warning("%s: %s", take, odd)


def warn_of_turned(references: Sequence[Frame], frame: Frame, take: str) -> None:
    """Warns where a frame is turned against the references of its own recording, all of shape (rows, columns, 3)."""
    if frame.shape == references[0].shape and (turned := turned_against(np.mean(references, 0), [frame])):
        _LOG.warning("%s: %s", take, turned)


def features_of(said: Sequence[Detection]) -> dict[str, Array]:
    """E, C and S that a detector tells of every frame, by name."""
    values = {name: [getattr(each, name) for each in said] for name in FEATURES}
    return {name: np.array(each, np.float64) for name, each in values.items() if each and None not in each}
