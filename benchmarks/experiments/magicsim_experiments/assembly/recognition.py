"""How often a misaligned base is recognised, by each cue, with intervals."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

from magicsim.sampling.bootstrap import CONFIDENCE
from magicsim_experiments.assembly.cues import Cues
from magicsim_experiments.assembly.misaligned import Misalignment
from magicsim_experiments.assembly.stages import BEFORE, EARLY


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """Share of trials that a cue recognises."""

    recognised: int
    of: int
    rate: float | None
    """None without any trial."""
    low: float | None
    """Wilson's interval of 95 %."""
    high: float | None

    @classmethod
    def of_trials(cls, found: Sequence[bool]) -> "Rate":
        """From what was found in each trial."""
        if not found:
            return cls(recognised=0, of=0, rate=None, low=None, high=None)
        count = int(sum(found))
        interval = binomtest(count, len(found)).proportion_ci(CONFIDENCE, method="wilson")
        return cls(
            recognised=count, of=len(found), rate=count / len(found), low=float(interval.low), high=float(interval.high)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Recognition:
    """What one cue makes of all trials."""

    threshold: float | None
    """Largest change of an aligned trial: none of these is called misaligned. None without aligned trials, and where
    one of them lost the plug before it met the base."""
    misaligned: Rate
    """Misaligned trials whose change is above it."""
    by_kind: Mapping[str, Rate]
    """Misaligned trials of each kind above it."""
    auc: float | None
    """Probability that a misaligned trial changes more than an aligned one; 1/2 is chance. None without both."""


def change(series: Sequence[Cues], value: Callable[[Cues], float]) -> float:
    """Largest change of a cue in the insertions against the approach; infinite where the plug was lost before.

    Args:
        series: One trial.
        value: The cue.
    """
    before = [value(each) for each in series if each.stage is BEFORE]
    early = [value(each) for each in series if each.stage in EARLY]
    return max(abs(each - before[-1]) for each in early) if early and before else float("inf")


CUES: Mapping[str, Callable[[Cues], float]] = {
    "ssim": lambda cues: cues.ssim,
    "contact detector": lambda cues: cues.similarity,
    "force label": lambda cues: cues.force_size_n,
}
"""The cues, by what is read of a step."""


def recognise(trials: Sequence[tuple[Misalignment, Sequence[Cues]]]) -> dict[str, Recognition]:
    """Recognition by each cue, and by a change of the contact detector's verdict (`contact verdict`).

    Args:
        trials: Misalignment and series of each.
    """
    found = {name: _by_change(trials, value) for name, value in CUES.items()}
    changed = [(each, _verdict_changes(series)) for each, series in trials]
    found["contact verdict"] = Recognition(
        threshold=None,
        misaligned=Rate.of_trials([was for each, was in changed if each.is_misaligned]),
        by_kind=_by_kind(changed),
        auc=None,
    )
    return found


def unrecognised(trials: Sequence[tuple[Misalignment, Sequence[Cues]]]) -> Rate:
    """Misaligned trials that neither SSIM nor contact detector recognises."""
    aligned = {name: _threshold(trials, CUES[name]) for name in ("ssim", "contact detector")}
    missed = [
        all(limit is None or change(series, CUES[name]) <= limit for name, limit in aligned.items())
        for each, series in trials
        if each.is_misaligned
    ]
    return Rate.of_trials(missed)


def _by_change(trials: Sequence[tuple[Misalignment, Sequence[Cues]]], value: Callable[[Cues], float]) -> Recognition:
    limit = _threshold(trials, value)
    changes = [(each, change(series, value)) for each, series in trials]
    wrong = [size for each, size in changes if each.is_misaligned]
    right = [size for each, size in changes if not each.is_misaligned]
    judged = [(each, limit is not None and size > limit) for each, size in changes]
    auc = None
    if wrong and right:
        auc = float(np.mean([(a > b) + (a == b) / 2 for a in wrong for b in right]))
    return Recognition(
        threshold=limit,
        misaligned=Rate.of_trials([was for each, was in judged if each.is_misaligned]),
        by_kind=_by_kind(judged),
        auc=auc,
    )


def _threshold(trials: Sequence[tuple[Misalignment, Sequence[Cues]]], value: Callable[[Cues], float]) -> float | None:
    most = max((change(series, value) for each, series in trials if not each.is_misaligned), default=math.inf)
    return most if math.isfinite(most) else None


def _by_kind(judged: Sequence[tuple[Misalignment, bool]]) -> dict[str, Rate]:
    kinds = sorted({each.kind for each, _ in judged if each.is_misaligned})
    return {kind: Rate.of_trials([was for each, was in judged if each.kind == kind]) for kind in kinds}


def _verdict_changes(series: Sequence[Cues]) -> bool:
    before = [each.verdicts for each in series if each.stage is BEFORE]
    return any(each.verdicts != before[-1] for each in series if each.stage in EARLY) if before else True
