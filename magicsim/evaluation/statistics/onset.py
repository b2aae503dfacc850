"""When a detector notices: how long before contact an approach, and how late a touch."""

from dataclasses import dataclass

import numpy as np

from magicsim.detectors.verdict import Contact, Proximity
from magicsim.evaluation.judged import JudgedEpisode
from magicsim.frame_class import FrameClass


@dataclass(frozen=True, slots=True, kw_only=True)
class Lead:
    """How early an approach was noticed for good."""

    frames: int
    """Frames called Approaching without a break right before contact."""
    seconds: float
    gap_mm: float
    """Gap at the first of them [mm], 0 where there is none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Onset:
    """How late a touch was noticed."""

    frames: int
    """Frames of class Contact before the first `Touched`; all of them where there is none."""
    depth_mm: float
    """Depth at the first `Touched` since the surfaces met [mm]; the deepest one where there is none."""


def approach_lead(episode: JudgedEpisode) -> Lead | None:
    """Lead before the first contact; None where no object comes from a distance to contact."""
    gap = episode.labels.gap_mm
    met = np.flatnonzero(gap <= 0)
    if not len(met) or met[0] == 0 or not gap[met[0] - 1] > 0:
        return None
    first = place = int(met[0])
    while place > 0 and gap[place - 1] > 0 and episode.proximity[place - 1] == Proximity.APPROACHING:
        place -= 1
    frames = first - place
    return Lead(frames=frames, seconds=frames / episode.frames_per_second, gap_mm=float(gap[place]) if frames else 0.0)


def touch_onset(episode: JudgedEpisode) -> Onset | None:
    """Onset of the first contact; None without a frame of class Contact, and where nobody knows how deep it is."""
    gap, classes = episode.labels.gap_mm, episode.labels.classes
    if FrameClass.CONTACT not in classes or not (gap <= 0).any():
        return None
    met = int(np.flatnonzero(gap <= 0)[0])
    left = np.flatnonzero(~(gap[met:] <= 0))
    end = met + (int(left[0]) if len(left) else len(gap) - met)
    said = [place for place in range(met, end) if episode.contact[place] == Contact.TOUCHED]
    deepest = float(-np.nanmin(gap[met:end]))
    noticed = said[0] if said else end
    missed = sum(classes[place] is FrameClass.CONTACT for place in range(met, noticed))
    return Onset(frames=missed, depth_mm=float(-gap[noticed]) if said else deepest)
