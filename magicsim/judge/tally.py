"""Episodes with their truth and what a detector says, and as numbers that add up, so that measures are weighted sums.

The episode is the independent unit: its frames share object, pose, placement, random numbers of the rendering and the
sensor's fixed pattern, and neighbours in time look nearly alike. Counting frames as independent would make every
interval several times too narrow, so resampling and permutation move whole episodes.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from magicsim.arrays import Array, Mask
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.judge.plausible import FELT_N
from magicsim.judge.score import PROXIMITY_TRUTH

Role = Literal["training", "held_out"]
"""Whether the calibration of the shipped profiles may have seen an episode."""
FIRST_PLACE = "own"
"""A suite's own sensor, where no places are given."""
SIMULATED, RECORDED = "simulated", "recorded"
"""Sensor of rendered frames, and of others whose own name nobody says; the latter is also a recording's path, light and
noise."""
LEVEL_NOISE = 0.05
"""Largest difference between means of a frame under other camera noise, or rounded by another processor [grey levels]:
0.3 grey levels of noise leave 0.001 of them in a frame of 240 x 320 pixels, and 0.01 in one of 48 x 36. Likewise
between looks."""
NOISE_SD = 8.0
"""Standard deviations of the camera's own noise by which levels and looks may differ where that is more."""


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
    sensor: str = SIMULATED
    """Which sensor took the frames."""

    @property
    def name(self) -> str:
        """Unique within a suite."""
        return f"{self.take}/{self.noise}"


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeLabels:
    """Truth of the frames after the references; all arrays have shape (frames,)."""

    gap_mm: Array
    """NaN without an object, negative when pressed."""
    force_n: Array
    """Size of the force; NaN where nobody knows."""
    flashlight: Mask
    classes: tuple[FrameClass | None, ...]
    """By the rules of `magicsim.frame_class`; None where a frame is not scored."""

    @classmethod
    def of(cls, gap_mm: Array, force_n: Array, flashlight: Mask) -> "EpisodeLabels":
        """EpisodeLabels with their classes; a force that nobody knows (NaN) is neither a contact nor none."""
        classes: list[FrameClass | None] = []
        for gap, force, light in zip(gap_mm.tolist(), force_n.tolist(), flashlight.tolist(), strict=True):
            if not math.isnan(gap):
                known_n = 0.0 if math.isnan(force) else force
                classes.append(classify_frame(gap_mm=gap, force_n=known_n, light_on=light))
            else:  # no object, unless something touches or nobody knows
                classes.append(classify_frame(gap_mm=None, light_on=light) if force <= FELT_N else None)
        return cls(gap_mm=gap_mm, force_n=force_n, flashlight=flashlight, classes=tuple(classes))


@dataclass(frozen=True, slots=True, kw_only=True)
class FramesSeen:
    """By what the frames of an episode are known again."""

    digest: str = ""
    """Hash of all pixels, references first, in hexadecimal digits; empty where nobody looked."""
    levels: tuple[float, ...] = ()
    """Mean of each frame after the references [grey levels]."""
    look: tuple[float, ...] = ()
    """Means over these frames: red, green and blue of their parts, and of the steps between neighbouring pixels, see
    `magicsim.evaluation.answers.look_of` [grey levels]; empty in older baselines, where levels alone tell."""
    level_sd: float = 0.0
    look_sd: float = 0.0
    """Standard deviations of a level, and the largest of a look, of references [grey levels]; 0 where unknown."""

    def is_alike(self, other: "FramesSeen") -> bool:
        """Whether both differ by camera noise and rounding at most; True where nobody looked at one of them."""
        if not self.digest or not other.digest or self.digest == other.digest:
            return True
        pairs = [(self.levels, other.levels, max(self.level_sd, other.level_sd))]
        if self.look and other.look:
            pairs.append((self.look, other.look, max(self.look_sd, other.look_sd) / math.sqrt(len(self.levels))))
        return all(
            len(one) == len(two) and np.allclose(one, two, rtol=0, atol=max(LEVEL_NOISE, NOISE_SD * spread))
            for one, two, spread in pairs
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedEpisode:
    """Verdicts and scores of the frames after the references."""

    tag: EpisodeTag
    labels: EpisodeLabels
    proximity: tuple[str, ...]
    contact: tuple[str, ...]
    approach: Array
    """Evidence for a nearby object, shape (frames,)."""
    touch: Array
    """Evidence for a touch, shape (frames,)."""
    features: Mapping[str, Array] = field(default_factory=dict)
    """`entropy`, `correlation` and `similarity` as far as the detector tells them of every frame, shape (frames,)."""
    milliseconds: float = 0.0
    """Median time of one step [ms]; belongs to the machine, so nothing is compared by it."""
    frames_per_second: float = 15.0
    seen: FramesSeen = FramesSeen()


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
    """Onset of the first touch that is scored; None without a frame of class Contact, or where its depth is unknown."""
    gap, classes = episode.labels.gap_mm, episode.labels.classes
    if FrameClass.CONTACT not in classes or not gap[classes.index(FrameClass.CONTACT)] <= 0:
        return None
    met = end = classes.index(FrameClass.CONTACT)
    while met > 0 and gap[met - 1] <= 0:
        met -= 1
    while end < len(gap) and gap[end] <= 0:
        end += 1
    said = [place for place in range(met, end) if episode.contact[place] == Contact.TOUCHED]
    deepest = float(-np.nanmin(gap[met:end]))
    noticed = said[0] if said else end
    missed = sum(classes[place] is FrameClass.CONTACT for place in range(met, noticed))
    return Onset(frames=missed, depth_mm=float(-gap[noticed]) if said else deepest)


SCORES = ("approach", "touch")
"""The two scores of a judged frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """Counts and pairings of episodes."""

    count: dict[str, Array]
    """Frames of a kind, shape (episodes,): `Near`, `Near said Approaching`, `Near said Touched`, ...; and the sums of
    their scores, `Near approach` and `Near touch`."""
    value: dict[str, Array]
    """One number an episode, NaN where it has none, shape (episodes,): lead, onset."""
    pairs: dict[str, Array]
    """Positive and negative frames whose scores stand in the right order, ties as a half, shape (episodes, episodes):
    `approach` (Near against Clear and Light) and `touch` (Contact against the rest)."""

    @property
    def episodes(self) -> int:
        """Number of episodes."""
        return len(next(iter(self.count.values())))


def tally(episodes: Sequence[JudgedEpisode]) -> Tally:
    """Counts, values and pairings of judged episodes."""
    count: dict[str, Array] = {}
    said = {verdict: [np.array(one.proximity) == verdict for one in episodes] for verdict in Proximity}
    touched = [np.array(one.contact) == Contact.TOUCHED for one in episodes]
    alarmed = [one | other for one, other in zip(said[Proximity.APPROACHING], touched, strict=True)]
    for each in FrameClass:
        held = [np.array([one is each for one in episode.labels.classes]) for episode in episodes]
        count[each] = np.array([mask.sum() for mask in held], np.float64)
        count |= {f"{each} said {verdict}": _both(held, masks) for verdict, masks in said.items()}
        count |= {f"{each} said {Contact.TOUCHED}": _both(held, touched), f"{each} alarmed": _both(held, alarmed)}
        for score in SCORES:
            count[f"{each} {score}"] = np.array([class_scores(one, score, {each}).sum() for one in episodes])
    leads: list[Any] = [approach_lead(each) for each in episodes]
    onsets: list[Any] = [touch_onset(each) for each in episodes]
    value = {
        f"{kind}_{unit}": np.array([np.nan if each is None else getattr(each, name) for each in found])
        for kind, unit, name, found in (
            ("lead", "mm", "gap_mm", leads), ("lead", "frames", "frames", leads), ("lead", "s", "seconds", leads),
            ("onset", "mm", "depth_mm", onsets), ("latency", "frames", "frames", onsets),
        )
    }  # fmt: skip
    return Tally(count=count, value=value, pairs=score_pairs(episodes))


def score_pairs(episodes: Sequence[JudgedEpisode]) -> dict[str, Array]:
    """`Tally.pairs` of judged episodes."""
    return {
        "approach": _pairs(episodes, "approach", {FrameClass.NEAR}, {FrameClass.CLEAR, FrameClass.LIGHT}),
        "touch": _pairs(episodes, "touch", {FrameClass.CONTACT}, set(FrameClass) - {FrameClass.CONTACT}),
    }


def class_scores(episode: JudgedEpisode, score: str, classes: set[FrameClass]) -> Array:
    """Scores of the frames of some classes, shape (frames of these,)."""
    chosen = np.array([one in classes for one in episode.labels.classes], bool)
    values: Array = getattr(episode, score)[chosen]
    return values


def _both(held: Sequence[Mask], said: Sequence[Mask]) -> Array:
    return np.array([(one & other).sum() for one, other in zip(held, said, strict=True)], np.float64)


def _pairs(
    episodes: Sequence[JudgedEpisode], score: str, positives: set[FrameClass], negatives: set[FrameClass]
) -> Array:
    above = [class_scores(each, score, positives) for each in episodes]
    below = [np.sort(class_scores(each, score, negatives)) for each in episodes]
    result = np.zeros((len(episodes), len(episodes)))
    for row, high in enumerate(above):
        for column, low in enumerate(below):
            wins = np.searchsorted(low, high, side="left").sum()
            ties = np.searchsorted(low, high, side="right").sum() - wins
            result[row, column] = wins + ties / 2
    return result


def confusion(episodes: Sequence[JudgedEpisode], *, coated: bool = False) -> dict[str, dict[str, dict[str, int]]]:
    """Frames by true class and verdict; proximity is not scored during contact, nor behind an opaque coat."""
    said = Counter(
        (task, truth, word)
        for each in episodes
        for task, words in (("proximity", [] if coated else each.proximity), ("contact", each.contact))
        for truth, word in zip(each.labels.classes, words, strict=not coated)
    )
    tasks: tuple[tuple[str, Iterable[FrameClass], Iterable[str]], ...] = (
        ("proximity", PROXIMITY_TRUTH, Proximity), ("contact", FrameClass, Contact),
    )  # fmt: skip
    return {
        task: {str(row): {str(column): said[task, row, column] for column in columns} for row in rows}
        for task, rows, columns in tasks
    }


def is_faultless(episode: JudgedEpisode, *, coated: bool = False) -> bool:
    """Whether every scored verdict is right; behind an opaque coat that of contact alone."""
    return all(
        truth is None
        or (
            (touch == Contact.TOUCHED) == (truth is FrameClass.CONTACT)
            and (coated or PROXIMITY_TRUTH.get(truth, near) == near)
        )
        for truth, near, touch in zip(episode.labels.classes, episode.proximity, episode.contact, strict=True)
    )
