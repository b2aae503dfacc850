"""The frames behind a change: where two runs of the same episode say different things, or the same less clearly."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TypeVar

import numpy as np

from magicsim.detectors.verdict import Contact, Proximity
from magicsim.frame_class import FrameClass
from magicsim.judge.measures import SCORE_MEANS, TABLE
from magicsim.judge.score import PROXIMITY_TRUTH
from magicsim.judge.tally import JudgedEpisode

Value = TypeVar("Value")


def runs(values: Sequence[Value]) -> Iterator[tuple[Value, range]]:
    """The longest stretches of equal neighbours, in order: the value and its places."""
    for value, group in groupby(range(len(values)), key=values.__getitem__):
        places = list(group)
        yield value, range(places[0], places[-1] + 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameRun:
    """Neighbouring frames of one episode that changed alike; frames are counted from the first after the references."""

    episode: str
    first: int
    last: int
    truth: str
    """Class of the frames, or `gap 5.0 mm` where they are not scored."""
    baseline: str
    """What the baseline's detector said."""
    current: str


def changed_runs(before: JudgedEpisode, now: JudgedEpisode, measure: str, *, worse: bool) -> list[FrameRun]:
    """Frames whose verdict changed in the direction of a change."""
    is_contact = TABLE[measure].task == "contact"
    old, new = (before.contact, now.contact) if is_contact else (before.proximity, now.proximity)
    # proximity is not scored during contact
    scored = set(range(len(old)) if is_contact else np.flatnonzero(~(now.labels.gap_mm <= 0)).tolist())
    changed = [
        (_truth(now, place), old[place], new[place])
        if place in scored and _became_worse(now, place, old[place], new[place], is_contact) is worse
        else None
        for place in range(len(old))
    ]
    return [_run(now, at, *said) for said, at in runs(changed) if said is not None]


def score_runs(before: JudgedEpisode, now: JudgedEpisode, measure: str, *, worse: bool, least: float) -> list[FrameRun]:
    """Frames whose score changed in the direction of a change, with the mean scores of neighbouring ones."""
    score, classes = SCORE_MEANS[measure]
    old, new = getattr(before, score), getattr(now, score)
    change = (new - old) * (1 if (TABLE[measure].better == "higher") is not worse else -1)
    pairs = zip(now.labels.classes, change, strict=True)
    changed = [str(truth) if truth in classes and by >= least else None for truth, by in pairs]

    return [
        _run(now, at, truth, *(f"{score} {values[list(at)].mean():.3g}" for values in (old, new)))
        for truth, at in runs(changed)
        if truth is not None
    ]


def _run(episode: JudgedEpisode, at: range, truth: str, baseline: str, current: str) -> FrameRun:
    name = episode.tag.name
    return FrameRun(episode=name, first=at[0], last=at[-1], truth=truth, baseline=baseline, current=current)


def _became_worse(episode: JudgedEpisode, place: int, old: str, new: str, is_contact: bool) -> bool | None:
    right = [_is_right(episode, place, said, is_contact) for said in (old, new)]
    return None if right[0] == right[1] else bool(right[0])


def _is_right(episode: JudgedEpisode, place: int, said: str, is_contact: bool) -> bool:
    """Right by the rules of the score; frames without a class are right where the object is noticed."""
    truth = episode.labels.classes[place]
    if is_contact:
        pressed = bool(episode.labels.gap_mm[place] <= 0)
        return (said == Contact.TOUCHED) == (truth is FrameClass.CONTACT or (truth is None and pressed))
    wanted = PROXIMITY_TRUTH.get(truth, Proximity.APPROACHING) if truth is not None else Proximity.APPROACHING
    return said == wanted


def _truth(episode: JudgedEpisode, place: int) -> str:
    truth, gap = episode.labels.classes[place], float(episode.labels.gap_mm[place])
    if truth is not None:
        return str(truth)
    return "unscored" if np.isnan(gap) else f"gap {gap:.2f} mm"
