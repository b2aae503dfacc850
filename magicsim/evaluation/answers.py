"""What a detector answers to the frames of an episode, checked, and kept beside the truth.

`Detector.step` is given one frame at a time, but a class that keeps what its other objects saw, or reads the folder of
the frames, knows later ones. It is found by another order: the frames up to the first contact in their own, the others
backwards. What is said of the first ones stays, and of the others it follows the frames.
"""

import logging
import math
import time
from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256
from itertools import islice
from typing import Any

import cv2
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

    `ConfigError` where it raises, an answer is missing or wrong, or it changes its references.
    """
    before = [each.copy() for each in references]
    detector = fitted(make, references, who=who)
    said, spent = [], []
    for number, frame in enumerate(frames):
        start = time.perf_counter()
        said.append(detection_of(detector, frame, who=who, which=f"frame {number} of {take}"))
        spent.append(time.perf_counter() - start)
    if not all(np.array_equal(*pair) for pair in zip(before, references, strict=True)):
        raise ConfigError(f"detector '{who}' changes its references in {take}; must leave their pixels as they are")
    return said, spent


PARTS = 4
"""Parts of a frame's side whose means are its look."""


def look_of(frame: Frame) -> Array:
    """Red, green and blue of the parts of a frame, PARTS x PARTS, and mean sizes of their steps along both axes.

    A frame that is brighter here and darker there has another look, and so has one that is sharper or more noisy, also
    where its mean level stays. Shape (3 PARTS PARTS + 3,) [grey levels].
    """
    levels = frame.astype(np.float32)
    steps = sum(np.abs(np.diff(levels, axis=axis)).mean((0, 1)) for axis in (0, 1) if levels.shape[axis] > 1)
    parts = cv2.resize(levels, (PARTS, PARTS), interpolation=cv2.INTER_AREA)
    return np.concatenate([parts.ravel(), steps + np.zeros(3)]).astype(np.float64)


class SeenFrames:
    """What becomes known of frames while they pass."""

    def __init__(self, references: Iterable[Frame]) -> None:
        self._digest, self._levels, self._looks = sha256(), list[float](), list[Array]()
        at_rest = []
        for each in references:
            self._add(each)
            at_rest.append((float(each.mean()), look_of(each)))
        levels, looks = zip(*at_rest, strict=True) if len(at_rest) > 1 else ([0, 0], [0, 0])
        self._spreads = [float(np.std(values, axis=0, ddof=1).max()) for values in (levels, looks)]

    def passed(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """The frames, each known once it has passed."""
        for each in frames:
            self._add(each)
            self._levels.append(float(each.mean()))
            self._looks.append(look_of(each))
            yield each

    @property
    def seen(self) -> FramesSeen:
        """All that has passed so far."""
        look = tuple(np.mean(self._looks, axis=0).tolist()) if self._looks else ()
        digest, (level_sd, look_sd) = self._digest.hexdigest()[:DIGITS], self._spreads
        return FramesSeen(digest=digest, levels=tuple(self._levels), look=look, level_sd=level_sd, look_sd=look_sd)

    def _add(self, frame: Frame) -> None:
        self._digest.update(str(frame.shape).encode())
        self._digest.update(np.ascontiguousarray(frame).data)


def check_detection(said: object, *, who: str) -> Detection:
    """A plug-in's answer, checked.

    `ConfigError` where one of the first four fields is missing, a verdict unknown, or a score not a finite number.
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
        frames = not_turned(frames, references, take)
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


def not_turned(frames: Iterable[Frame], references: Sequence[Frame], take: str) -> Iterator[Frame]:
    """The frames, with a warning where the first one is turned against the references of its own recording.

    All have shape (rows, columns, 3).
    """
    for number, frame in enumerate(frames):
        if number == 0 and frame.shape == references[0].shape:
            turned = turned_against(np.mean(references, 0), [frame])
            if turned:
                _LOG.warning("%s: %s", take, turned)
        yield frame


def features_of(said: Sequence[Detection]) -> dict[str, Array]:
    """E, C and S that a detector tells of every frame, by name."""
    values = {name: [getattr(each, name) for each in said] for name in FEATURES}
    return {name: np.array(each, np.float64) for name, each in values.items() if each and None not in each}


MOST_FRAMES = 120
"""Frames of an episode that are tried in another order, at most."""


def check_order(footage: Footage, make: MakeDetector, *, who: str) -> None:
    """Tries a detector on an episode's frames in their order and in another.

    `ConfigError` where it says other things of the first frames, or the same of others that came backwards.
    """
    references = list(footage.images.references())
    frames = list(islice(footage.images.frames(), MOST_FRAMES))
    met = np.flatnonzero(footage.labels.gap_mm[: len(frames)] <= 0)
    turn = int(met[0]) if len(met) else len(frames) // 2
    other = frames[:turn] + frames[turn:][::-1]
    before, after = (answers_to(each, references, make, footage.tag.take, who=who)[0] for each in (frames, other))
    name, take = f"detector '{who}'", footage.tag.take
    for place in range(turn):
        if _words(before[place]) != _words(after[place]):
            said = " then ".join("/".join(_words(each[place])) for each in (before, after))
            raise ConfigError(
                f"{name} reads the future, or differs from run to run: of frame {place} of {take} it said {said}, when "
                f"the frames from {turn} on came in another order; must follow from references and frames so far"
            )
    is_other = any(not np.array_equal(*pair) for pair in zip(frames[turn:], other[turn:], strict=True))
    if is_other and before[turn:] == after[turn:] and len(set(before[turn:])) > 1:
        raise ConfigError(
            f"{name} does not look at the frames: of those from {turn} on of {take} it said one after the other the "
            "same when they came backwards; must follow from references and frames so far"
        )


def _words(said: Detection) -> tuple[str, str]:
    return str(said.proximity), str(said.contact)
