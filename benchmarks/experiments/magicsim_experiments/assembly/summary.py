"""Who noticed misalignment, over all trials, and what each cue is in each stage."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from magicsim.judge.measures import exact_share
from magicsim.robot.grip.load import Hold
from magicsim_experiments.assembly.stages import BEFORE, EARLY, Misalignment, TrialStage
from magicsim_experiments.assembly.trial import Cues
from magicsim_experiments.task.growing import as_png
from magicsim_experiments.task.summary import reasons_of

Series = Sequence[tuple[Misalignment, Sequence[Cues]]]
"""Misalignment of each trial, and what was read at its steps."""
COLORS = {"aligned": "tab:green", "offset": "tab:red", "angle": "tab:orange"}
MANY = 20
"""Trials from which on lines are drawn fainter."""


def draw_series(trials: Series) -> bytes:
    """A PNG of every trial."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    labelled, alpha = set(), 0.7 if len(trials) < MANY else 0.3
    for misalignment, series in trials:
        kind = misalignment.kind
        label = kind if kind not in labelled else None
        labelled.add(kind)
        times = [cues.time_s for cues in series]
        upper.plot(times, [cues.ssim for cues in series], "o-", color=COLORS[kind], label=label, alpha=alpha)
        lower.plot(times, [cues.force_size_n for cues in series], "o-", color=COLORS[kind], alpha=alpha)
    upper.set_ylabel("SSIM, mean of both fingers")
    lower.set_ylabel("force of the base [N]")
    lower.set_xlabel("time [s]")
    upper.legend(title="base")
    ends = stage_ends_s([series for _, series in trials])
    above = upper.secondary_xaxis("top")
    above.set_xticks(list(ends.values()), [stage.value.split()[0] for stage in ends])
    for axes in (upper, lower):
        for end in ends.values():
            axes.axvline(end, color="grey", linewidth=0.5)
        axes.grid(visible=True, alpha=0.3)
    return as_png(figure)


def stage_ends_s(trials: Sequence[Sequence[Cues]]) -> dict[TrialStage, float]:
    """When each stage that was played ends, the median over trials [s]."""
    lasts: dict[TrialStage, list[float]] = {}
    for series in trials:
        for stage, last in {cues.stage: cues.time_s for cues in series}.items():
            lasts.setdefault(stage, []).append(last)
    return {stage: float(np.median(lasts[stage])) for stage in TrialStage if stage in lasts}


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """Share of trials that a cue recognises."""

    recognised: int
    of: int
    rate: float | None
    """None without any trial."""
    low: float | None
    """Exact interval of 95 %."""
    high: float | None

    @classmethod
    def of_trials(cls, found: Sequence[bool]) -> "Rate":
        """From what was found in each trial."""
        count = int(sum(found))
        share = exact_share(count, len(found))
        return cls(recognised=count, of=len(found), rate=share.value, low=share.low, high=share.high)


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
    """Largest change of a cue in the insertions against the approach; infinite where the plug was lost before."""
    before = [value(each) for each in series if each.stage is BEFORE]
    early = [value(each) for each in series if each.stage in EARLY]
    return max(abs(each - before[-1]) for each in early) if early and before else float("inf")


CUES: Mapping[str, Callable[[Cues], float]] = {
    "ssim": lambda cues: cues.ssim,
    "contact detector": lambda cues: cues.similarity,
    "force label": lambda cues: cues.force_size_n,
}
"""The cues, by what is read of a step."""


def recognise(trials: Series) -> dict[str, Recognition]:
    """Recognition by each cue, and by a change of the contact detector's verdict (`contact verdict`)."""
    verdicts = _recognition([(each, _verdict_changes(series)) for each, series in trials])
    return {name: _by_change(trials, value) for name, value in CUES.items()} | {"contact verdict": verdicts}


def unrecognised(trials: Series) -> Rate:
    """Misaligned trials that neither SSIM nor contact detector recognises."""
    aligned = {name: _threshold(trials, CUES[name]) for name in ("ssim", "contact detector")}
    missed = [
        all(limit is None or change(series, CUES[name]) <= limit for name, limit in aligned.items())
        for each, series in trials
        if each.is_misaligned
    ]
    return Rate.of_trials(missed)


def _by_change(trials: Series, value: Callable[[Cues], float]) -> Recognition:
    limit = _threshold(trials, value)
    changes = [(each, change(series, value)) for each, series in trials]
    wrong = [size for each, size in changes if each.is_misaligned]
    right = [size for each, size in changes if not each.is_misaligned]
    ordered = [(a > b) + (a == b) / 2 for a in wrong for b in right]
    judged = [(each, limit is not None and size > limit) for each, size in changes]
    return _recognition(judged, threshold=limit, auc=float(np.mean(ordered)) if ordered else None)


def _recognition(
    judged: Sequence[tuple[Misalignment, bool]], *, threshold: float | None = None, auc: float | None = None
) -> Recognition:
    """Rates of the misaligned trials, of each of which is told whether it was recognised."""
    found = [(each.kind, was) for each, was in judged if each.is_misaligned]
    kinds: list[str] = sorted({kind for kind, _ in found})
    by_kind = {kind: Rate.of_trials([was for own, was in found if own == kind]) for kind in kinds}
    misaligned = Rate.of_trials([was for _, was in found])
    return Recognition(threshold=threshold, misaligned=misaligned, by_kind=by_kind, auc=auc)


def _threshold(trials: Series, value: Callable[[Cues], float]) -> float | None:
    most = max((change(series, value) for each, series in trials if not each.is_misaligned), default=math.inf)
    return most if math.isfinite(most) else None


def _verdict_changes(series: Sequence[Cues]) -> bool:
    before = [each.verdicts for each in series if each.stage is BEFORE]
    return any(each.verdicts != before[-1] for each in series if each.stage in EARLY) if before else True


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One trial as it is kept."""

    misalignment: Misalignment
    steps: tuple[Cues, ...]
    """Up to where the plug was lost; none where the trial failed."""
    error: str
    """Why it failed, such as that no equilibrium was found; empty otherwise."""

    @classmethod
    def read(cls, values: dict[str, Any]) -> "Trial":
        """From JSON, as `dataclasses.asdict` makes it."""
        return cls(
            misalignment=Misalignment(**values["misalignment"]),
            steps=tuple(_cues(step) for step in values["steps"]),
            error=values["error"],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StageSeries:
    """What a cue is in one stage, over the steps of trials in which the plug was not lost."""

    trials: int
    mean: float
    least: float
    most: float


@dataclass(frozen=True, slots=True, kw_only=True)
class AssemblySummary:
    """What `magicsim task assembly` reports."""

    out: str
    trials: int
    failed: int
    """Trials that could not be played to their end, as without a valid equilibrium; left out of everything else."""
    reasons: dict[str, int]
    """Why they failed, and how many of them."""
    dropped: int
    recognised: dict[str, Recognition]
    neither: Rate
    """Misaligned trials that neither SSIM nor contact detector recognises."""
    stages: dict[str, dict[str, dict[str, StageSeries]]]


def played_out(trials: Sequence[Trial]) -> list[tuple[Misalignment, tuple[Cues, ...]]]:
    """Misalignment and series of the trials that did not fail."""
    return [(each.misalignment, each.steps) for each in trials if not each.error]


def summarise(trials: Sequence[Trial], *, out: str) -> AssemblySummary:
    """Sums up a run."""
    played = played_out(trials)
    reasons = reasons_of([each.error for each in trials])
    return AssemblySummary(
        out=out, trials=len(trials), failed=sum(reasons.values()), reasons=reasons,
        dropped=sum(series[-1].stage is not TrialStage.OPEN for _, series in played), recognised=recognise(played),
        neither=unrecognised(played), stages=_by_stage(played),
    )  # fmt: skip


def _by_stage(played: Series) -> dict[str, dict[str, dict[str, StageSeries]]]:
    found: dict[str, dict[str, dict[str, StageSeries]]] = {}
    for kind in sorted({each.kind for each, _ in played}):
        series = [cues for each, whole in played if each.kind == kind for cues in whole]
        found[kind] = {}
        for stage in TrialStage:
            here = [cues for cues in series if cues.stage is stage and cues.outcome != Hold.DROPPED]
            if here:
                read = {name: [value(cues) for cues in here] for name, value in CUES.items()}
                found[kind][stage.value] = {
                    name: StageSeries(trials=len(each), mean=float(np.mean(each)), least=min(each), most=max(each))
                    for name, each in read.items()
                }
    return found


def _cues(step: dict[str, Any]) -> Cues:
    tuples = {name: tuple(value) for name, value in step.items() if isinstance(value, list)}
    return Cues(**(step | tuples | {"stage": TrialStage(step["stage"])}))
