"""The frames behind a change: where two runs of the same episode say different things, or the same less clearly."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from magicsim.detectors.verdict import Contact, Proximity
from magicsim.frame_class import FrameClass
from magicsim.judge.judged import JudgedEpisode
from magicsim.judge.measures import SCORE_MEANS
from magicsim.judge.score import PROXIMITY_TRUTH

CONTACT_MEASURES = {"contact_balanced_accuracy", "onset_mm", "touch_auc"}


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
    """What is said now."""


def changed_runs(before: JudgedEpisode, now: JudgedEpisode, measure: str, *, worse: bool) -> list[FrameRun]:
    """Frames whose verdict changed in the direction of a change."""
    is_contact = measure in CONTACT_MEASURES
    old, new = (before.contact, now.contact) if is_contact else (before.proximity, now.proximity)
    scored = set(range(len(old))) if is_contact else _outside_contact(now)
    told = [
        (_truth(now, place), old[place], new[place])
        if place in scored and _became_worse(now, place, old[place], new[place], is_contact) is worse
        else None
        for place in range(len(old))
    ]
    return list(_runs(now.tag.name, told))


def score_runs(before: JudgedEpisode, now: JudgedEpisode, measure: str, *, worse: bool, least: float) -> list[FrameRun]:
    """Frames whose score changed in the direction of a change, with the mean scores of neighbouring ones."""
    mean = SCORE_MEANS[measure]
    old, new = getattr(before, mean.score), getattr(now, mean.score)
    change = (new - old) * (1 if mean.is_positive is not worse else -1)
    told = [
        str(truth) if truth in mean.classes and by >= least else None
        for truth, by in zip(now.labels.classes, change, strict=True)
    ]
    runs = []
    for truth, group in groupby(enumerate(told), key=lambda pair: pair[1]):
        places = [place for place, _ in group]
        if truth is not None:
            means = [f"{mean.score} {values[places].mean():.3g}" for values in (old, new)]
            runs.append(
                FrameRun(
                    episode=now.tag.name, first=places[0], last=places[-1], truth=truth, baseline=means[0],
                    current=means[1],
                )
            )  # fmt: skip
    return runs


def _outside_contact(episode: JudgedEpisode) -> set[int]:
    """Frames without contact: proximity is not scored during it."""
    return set(np.flatnonzero(~(episode.labels.gap_mm <= 0)).tolist())


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


def _runs(name: str, told: list[tuple[str, str, str] | None]) -> Iterator[FrameRun]:
    for said, group in groupby(enumerate(told), key=lambda pair: pair[1]):
        if said is None:
            continue
        places = [place for place, _ in group]
        yield FrameRun(episode=name, first=places[0], last=places[-1], truth=said[0], baseline=said[1], current=said[2])
