"""E, C and S of the untouched sensor, and verdicts that stand on less than what they do there by themselves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from magicsim.detectors.verdict import Contact, Proximity, Verdict

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
