"""What the verdicts rest on: E, C and S in each part of the story, in units of their spread on the untouched sensor."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.detectors.verdict import FEATURES, FeatureAtRest
from magicsim.judge.verdicts import Judgement
from magicsim.report.story import tell_phases
from magicsim.report.text import number
from magicsim.simulation.episode import SimulatedFrame

THRESHOLDS = {"entropy": "tau_e", "correlation": "tau_c", "similarity": "tau_g"}
"""Threshold of each measure of a verdict."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestRow:
    """One measure."""

    name: str
    at_rest: str
    threshold: str
    parts: tuple[str, ...]
    """In each part of the story: median and d'."""


def rest_rows(frames: Sequence[SimulatedFrame], judgement: Judgement) -> tuple[list[str], list[RestRow]]:
    """Parts of the story that have frames, and one row a measure; none where nothing was said of the rest.

    Args:
        frames: The scored frames.
        judgement: Verdicts on them, and the spread at rest.
    """
    phases = tell_phases(frames)
    parts = list(dict.fromkeys(phases))
    rows = []
    for key, name in FEATURES.items():
        rest = judgement.at_rest.get(key)
        if rest is None:
            continue
        values = np.array([getattr(each, key) for each in judgement.verdicts])
        medians = [float(np.median(values[[one == part for one in phases]])) for part in parts]
        rows.append(
            RestRow(
                name=name,
                at_rest=f"{rest.mean:.3f} ± {rest.sd:.2g}",
                threshold=_with_distance(judgement.thresholds[THRESHOLDS[key]], rest),
                parts=tuple(_with_distance(each, rest) for each in medians),
            )
        )
    return [str(part) for part in parts], rows


def _with_distance(value: float, rest: FeatureAtRest) -> str:
    return f"{number(value, 3)} ({rest.distance(value):+.0f})"
