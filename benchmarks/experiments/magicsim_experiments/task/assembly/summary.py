"""Who noticed misalignment, over all trials, and what each cue is in each stage."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from magicsim.robot.grip.load import Hold
from magicsim_experiments.assembly.cues import Cues
from magicsim_experiments.assembly.misaligned import Misalignment
from magicsim_experiments.assembly.recognition import CUES, Rate, Recognition, recognise, unrecognised
from magicsim_experiments.assembly.stages import Stage
from magicsim_experiments.task.summary import reasons_of


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
    """The folder."""
    trials: int
    failed: int
    """Trials that could not be played to their end, as without a valid equilibrium; left out of everything else."""
    reasons: dict[str, int]
    """Why they failed, and how many of them."""
    dropped: int
    """Trials in which the plug was lost."""
    recognised: dict[str, Recognition]
    """By cue: misaligned trials that it recognises."""
    neither: Rate
    """Misaligned trials that neither SSIM nor contact detector recognises."""
    stages: dict[str, dict[str, dict[str, StageSeries]]]
    """By kind of trial, stage and cue."""


def played_out(trials: Sequence[Trial]) -> list[tuple[Misalignment, tuple[Cues, ...]]]:
    """Misalignment and series of the trials that did not fail."""
    return [(each.misalignment, each.steps) for each in trials if not each.error]


def summarise(trials: Sequence[Trial], *, out: str) -> AssemblySummary:
    """Sums up a run.

    Args:
        trials: All of them.
        out: Folder of the run.
    """
    played = played_out(trials)
    reasons = reasons_of([each.error for each in trials])
    return AssemblySummary(
        out=out,
        trials=len(trials),
        failed=sum(reasons.values()),
        reasons=reasons,
        dropped=sum(series[-1].stage is not Stage.OPEN for _, series in played),
        recognised=recognise(played),
        neither=unrecognised(played),
        stages=_by_stage(played),
    )


def _by_stage(
    played: Sequence[tuple[Misalignment, tuple[Cues, ...]]],
) -> dict[str, dict[str, dict[str, StageSeries]]]:
    found: dict[str, dict[str, dict[str, StageSeries]]] = {}
    for kind in sorted({each.kind for each, _ in played}):
        series = [cues for each, whole in played if each.kind == kind for cues in whole]
        found[kind] = {}
        for stage in Stage:
            here = [cues for cues in series if cues.stage is stage and cues.outcome != Hold.DROPPED]
            if here:
                found[kind][stage.value] = {
                    name: _series([value(cues) for cues in here]) for name, value in CUES.items()
                }
    return found


def _series(values: list[float]) -> StageSeries:
    return StageSeries(trials=len(values), mean=float(np.mean(values)), least=min(values), most=max(values))


def _cues(step: dict[str, Any]) -> Cues:
    tuples = {name: tuple(value) for name, value in step.items() if isinstance(value, list)}
    return Cues(**(step | tuples | {"stage": Stage(step["stage"])}))
