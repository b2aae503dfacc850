"""Pictures of an evaluation: one frame near and one in contact of every take, and frames that changed for the worse."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from magicsim.arrays import Frame
from magicsim.evaluation.judged import JudgedEpisode
from magicsim.evaluation.statistics.changed_frames import FrameRun
from magicsim.evaluation.takes.footage import Footage
from magicsim.frame_class import FrameClass
from magicsim.report.images import data_uri
from magicsim.report.palette import CLASS_COLORS
from magicsim.report.text import gap_or_depth

MOST_CHANGED = 12
"""Pictures of changed frames, at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One frame with what is true and what is said of it."""

    uri: str
    title: str
    place: str
    truth: str
    color: str
    said: str


def sheet(footage: Sequence[Footage], episodes: Sequence[JudgedEpisode], standard: str) -> list[Picture]:
    """A near and a pressed frame of every take in the standard condition, and a lit one of every other light."""
    noise = standard.partition("/")[2]
    pictures = []
    for film, episode in zip(footage, episodes, strict=True):
        if film.tag.noise != noise:
            continue
        places = [_nearest(episode, FrameClass.NEAR, 1.0), _nearest(episode, FrameClass.CONTACT, -9.0)]
        pictures += _pictures(film, episode, [place for place in places if place is not None])
    return pictures


def changed_sheet(
    footage: Sequence[Footage], episodes: Sequence[JudgedEpisode], runs: Sequence[FrameRun]
) -> list[Picture]:
    """The first frame of every run that changed, up to a dozen."""
    wanted: dict[str, list[int]] = {}
    for run in list(runs)[:MOST_CHANGED]:
        wanted.setdefault(run.episode, []).append(run.first)
    pictures = []
    for film, episode in zip(footage, episodes, strict=True):
        pictures += _pictures(film, episode, sorted(set(wanted.get(film.tag.name, ()))))
    return pictures


def _pictures(film: Footage, episode: JudgedEpisode, places: Sequence[int]) -> list[Picture]:
    if not places:
        return []
    images = dict(enumerate(islice(film.images.frames(), max(places) + 1)))
    return [_picture(images[place], film, episode, place) for place in places]


def _picture(image: Frame, film: Footage, episode: JudgedEpisode, place: int) -> Picture:
    truth, gap = episode.labels.classes[place], float(episode.labels.gap_mm[place])
    light = ", flashlight" if episode.labels.flashlight[place] else ""
    return Picture(
        uri=data_uri(image),
        title=f"{film.tag.name} {place}",
        place=gap_or_depth(None if np.isnan(gap) else gap) + light,
        truth=str(truth) if truth is not None else "not scored",
        color=CLASS_COLORS[truth] if truth is not None else "transparent",
        said=f"{episode.proximity[place]}, {episode.contact[place]}",
    )


def _nearest(episode: JudgedEpisode, truth: FrameClass, gap_mm: float) -> int | None:
    """The frame of a class whose gap is nearest to one."""
    held = [place for place, one in enumerate(episode.labels.classes) if one is truth]
    return min(held, key=lambda place: abs(float(episode.labels.gap_mm[place]) - gap_mm), default=None)
