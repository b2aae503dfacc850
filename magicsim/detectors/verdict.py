"""Verdicts of one frame, and how far its measures E, C and S stand from the untouched sensor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum

import numpy as np


class Proximity(StrEnum):
    """Verdict of the proximity algorithm."""

    NORMAL = "Normal"
    """Nothing brightens."""
    APPROACHING = "Approaching"
    """The channels brighten differently: an object seen through the side-lit grid."""
    NOISE = "Noise"
    """The channels brighten alike: light from outside."""


class Contact(StrEnum):
    """Verdict of the contact algorithm, and of the combined detection, which alone says `Unknown`."""

    TOUCHED = "Touched"
    """The grid looks different from the untouched one."""
    UNTOUCHED = "Untouched"
    """The grid is where it was."""
    UNKNOWN = "Unknown"
    """Outside light changes the grid's look too, so the frame is no evidence either way."""


NUMBERS = ("entropy", "correlation", "similarity", "p_approach", "p_noise", "p_touch")
"""Fields of a verdict that are numbers."""
WORDS = ("proximity", "contact", "combined")
"""Fields that are words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Features, probabilities and verdicts of one frame; E, C and S in units of rest where the profile says so."""

    entropy: float
    """Shannon entropy E of the brightening [bit], 0..8."""
    correlation: float
    """Mean pairwise Pearson correlation C of the brightened channels, -1..1."""
    similarity: float
    """Grid similarity S, 0..1."""
    p_approach: float
    """Probability of a nearby object, 0..1."""
    p_noise: float
    """Probability of outside light, 0..1."""
    p_touch: float
    """Probability of a touch from the similarity alone, 0..1."""
    proximity: Proximity
    """Verdict from E and C."""
    contact: Contact
    """Verdict from S alone: `Touched` or `Untouched`."""
    combined: Contact
    """The contact verdict, `Unknown` where proximity says `Noise`."""
    weak: bool | None = field(default=None, compare=False)
    """Whether it rests on less than the camera's own repeatability, see `magicsim.detectors.verdict`; None where the
    spread at rest is not known."""
    source: str | None = None
    """Where the frame came from, such as a file name; None for an array in memory."""

    def as_dict(self) -> dict[str, float | str]:
        """The fields ready for JSON, without `weak` and `source` where there are none."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


FEATURES = {"entropy": "E [bit]", "correlation": "C", "similarity": "S"}
"""Measures of a frame whose spread at rest is told, and what they are called."""
REPEATABILITY_SD = 3.0
"""A verdict nearer to rest than this rests on less than the camera's own repeatability [standard deviations]: in 95 of
100 pairs two frames of one thing differ by at most 2.8 (ISO 5725-6)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FeatureAtRest:
    """One of E, C and S on the untouched sensor."""

    mean: float
    sd: float
    """From one frame to the next: the camera's own repeatability."""

    def distance(self, value: float) -> float:
        """How far a value is from rest, signed [standard deviations]: d' of a frame. Infinite where nothing varies."""
        if self.sd > 0:
            return (value - self.mean) / self.sd
        return 0.0 if value == self.mean else float(np.copysign(np.inf, value - self.mean))


def features_at_rest(verdicts: Sequence[Verdict]) -> dict[str, FeatureAtRest]:
    """Mean and spread of E, C and S by name, from verdicts on frames of the untouched sensor."""
    values = {name: [getattr(each, name) for each in verdicts] for name in FEATURES}
    return {
        name: FeatureAtRest(mean=float(np.mean(each)), sd=float(np.std(each, ddof=1)) if len(each) > 1 else 0.0)
        for name, each in values.items()
    }


def marked(verdict: Verdict, rest: Mapping[str, FeatureAtRest]) -> Verdict:
    """A verdict with `weak`: whether it says more than rest, and the frame is nearer to it than `REPEATABILITY_SD`.

    `Touched` rests on a fall of S, `Approaching` and `Noise` on a rise of E.
    """
    touched = verdict.combined is Contact.TOUCHED
    brighter = verdict.proximity is not Proximity.NORMAL
    falls, rises = -rest["similarity"].distance(verdict.similarity), rest["entropy"].distance(verdict.entropy)
    return replace(verdict, weak=(touched and falls < REPEATABILITY_SD) or (brighter and rises < REPEATABILITY_SD))
