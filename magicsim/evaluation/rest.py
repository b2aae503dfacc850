"""The untouched sensor in a long stream: how far its frames are from a false alarm, and how often they give one.

Scores between 0 and 1 are read as probabilities whose verdict turns at 1/2; their logarithms of odds are nearly normal
at rest, so that their distance from 0 in standard deviations tells the margin of a threshold, and the distance of a
touched frame from them its d' (Green and Swets 1966).
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from magicsim.arrays import Array, Mask
from magicsim.detectors.verdict import REPEATABILITY_SD, Contact, FeatureAtRest, Proximity
from magicsim.evaluation.answers import detection_of, features_of, fitted
from magicsim.evaluation.detector import MakeDetector
from magicsim.evaluation.footage import ExposedTake, Footage
from magicsim.frame_class import FrameClass
from magicsim.judge.measures import count_ends
from magicsim.judge.tally import JudgedEpisode

_LOG = logging.getLogger(__name__)
HOUR_S = 3600.0
MOST_SD = 1e6
"""Where nothing varies at rest, every other frame is as far as this from it [standard deviations]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreAtRest:
    """Logarithms of a score's odds over the frames of a stream at rest."""

    mean: float
    sd: float
    margin_sd: float
    """How far the mean is from where the verdict turns, in standard deviations; negative where rest gives an alarm."""
    weak_verdicts: int
    """Right verdicts on frames whose d' is below `REPEATABILITY_SD`."""
    verdicts: int
    """All right verdicts of the kind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureAtRest:
    """E, C or S over the frames of a stream at rest, and how far from it other frames are."""

    mean: float
    sd: float
    touch_d: float | None
    """Median d' of frames in contact: (value - mean) / sd, signed; None without any."""
    approach_d: float | None
    """Median d' of near frames, likewise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """One sensor in one place, through one camera."""

    place: str
    noise: str
    frames: int
    alarms: int
    """Frames called Approaching or Touched."""
    alarms_per_hour: float
    low: float
    high: float
    """Ends of the exact 95 % interval of a Poisson count."""
    expected_per_hour: float | None
    """What the tails of normal scores promise; None where scores are no probabilities."""
    touch: ScoreAtRest | None
    approach: ScoreAtRest | None
    features: dict[str, MeasureAtRest]
    """`entropy`, `correlation` and `similarity`, as far as the detector tells them."""


def rest_streams(
    footage: Sequence[Footage], episodes: Sequence[JudgedEpisode], make: MakeDetector, *, seconds: float, who: str
) -> list[Rest]:
    """One stream of so many seconds for every place and noise of some footage, by the first take of each.

    Recordings have none, nor places where something passes in the room, which a warning says, and no stream is filmed
    with 0 seconds. The detector is made anew for every stream.
    """
    first: dict[tuple[str, str], Footage] = {}
    moving: set[str] = set()
    for film in footage:
        if isinstance(film.images, ExposedTake):
            if film.images.passes:
                moving.add(film.tag.place)
            else:
                first.setdefault((film.tag.place, film.tag.noise), film)
    if moving and seconds > 0:
        places = ", ".join(sorted(moving))
        _LOG.warning(
            "no stream at rest is filmed in place %s: what passes in its room is rendered in takes alone", places
        )
    return [
        _rest(film, [one for one in episodes if (one.tag.place, one.tag.noise) == key], make, seconds=seconds, who=who)
        for key, film in first.items()
        if round(seconds * film.frames_per_second) > 1
    ]


def _rest(film: Footage, episodes: Sequence[JudgedEpisode], make: MakeDetector, *, seconds: float, who: str) -> Rest:
    assert isinstance(film.images, ExposedTake)
    detector = fitted(make, film.images.references(), who=who)
    count = round(seconds * film.frames_per_second)
    said = [detection_of(detector, frame, who=who) for frame in film.images.at_rest(count)]
    alarms = sum(each.proximity == Proximity.APPROACHING or each.contact == Contact.TOUCHED for each in said)
    hours = count / film.frames_per_second / HOUR_S
    low, high = count_ends(alarms)
    touches, approaches = np.array([[each.touch, each.approach] for each in said]).T
    touch = _score(touches, episodes, "touch", FrameClass.CONTACT, Contact.TOUCHED)
    approach = _score(approaches, episodes, "approach", FrameClass.NEAR, Proximity.APPROACHING)
    tails = [ndtr(-each.margin_sd) for each in (touch, approach) if each is not None]
    return Rest(
        place=film.tag.place, noise=film.tag.noise, frames=count, alarms=alarms, alarms_per_hour=alarms / hours,
        low=low / hours, high=high / hours,
        expected_per_hour=float(sum(tails)) * film.frames_per_second * HOUR_S if tails else None,
        touch=touch, approach=approach,
        features={name: _measure(values, episodes, name) for name, values in features_of(said).items()},
    )  # fmt: skip


def _measure(values: Array, episodes: Sequence[JudgedEpisode], name: str) -> MeasureAtRest:
    rest = FeatureAtRest(mean=float(values.mean()), sd=float(values.std(ddof=1)))
    pairs = [pair for each in episodes for pair in zip(each.labels.classes, each.features.get(name, ()), strict=False)]

    def median_d(truth: FrameClass) -> float | None:
        distances = [rest.distance(value) for one, value in pairs if one is truth]
        return float(np.clip(np.median(distances), -MOST_SD, MOST_SD)) if distances else None

    touch, approach = median_d(FrameClass.CONTACT), median_d(FrameClass.NEAR)
    return MeasureAtRest(mean=rest.mean, sd=rest.sd, touch_d=touch, approach_d=approach)


def _score(
    at_rest: Array, episodes: Sequence[JudgedEpisode], name: str, truth: FrameClass, verdict: str
) -> ScoreAtRest | None:
    """A score at rest, and the right verdicts that lie near it; None where a score is no probability."""
    scores = [np.asarray(getattr(each, name), np.float64) for each in episodes]
    if any(((each < 0) | (each > 1)).any() for each in [at_rest, *scores]):
        return None
    odds = log_odds(at_rest)
    mean, spread = float(odds.mean()), float(odds.std(ddof=1))
    judged = zip(episodes, scores, strict=True)
    near = [(log_odds(score) - mean)[_is_right(each, truth, verdict)] for each, score in judged]
    right = np.concatenate(near or [np.zeros(0)])
    return ScoreAtRest(
        mean=mean,
        sd=spread,
        margin_sd=-mean / spread if spread > 0 else float(np.copysign(MOST_SD, -mean)),
        weak_verdicts=int((right < REPEATABILITY_SD * spread).sum()),
        verdicts=len(right),
    )


def _is_right(episode: JudgedEpisode, truth: FrameClass, verdict: str) -> Mask:
    said = episode.contact if truth is FrameClass.CONTACT else episode.proximity
    return np.array([one is truth and word == verdict for one, word in zip(episode.labels.classes, said, strict=True)])


def log_odds(probability: Array) -> Array:
    """Logarithm of p / (1 - p), finite at 0 and 1."""
    inside = np.clip(probability, 1e-300, 1 - 1e-16)
    return np.asarray(np.log(inside) - np.log1p(-inside))
