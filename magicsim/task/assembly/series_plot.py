"""SSIM against the steps of a trial in their order, the force labels beside it; a tick is where a stage begins."""

import io
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate

from matplotlib.figure import Figure

from magicsim.robot.assembly.cues import Cues
from magicsim.robot.assembly.misaligned import Misalignment
from magicsim.robot.assembly.stages import Stage

COLORS = {"aligned": "tab:green", "offset": "tab:red", "angle": "tab:orange"}
MANY = 20
"""Trials from which on lines are drawn fainter."""


def draw_series(trials: Sequence[tuple[Misalignment, Sequence[Cues]]]) -> bytes:
    """A PNG of every trial.

    Args:
        trials: Misalignment and series of each.
    """
    figure = Figure(figsize=(8, 5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    begins = stage_begins(series for _, series in trials)
    told, alpha = set(), 0.7 if len(trials) < MANY else 0.3
    for misalignment, series in trials:
        kind = misalignment.kind
        label = kind if kind not in told else None
        told.add(kind)
        x = step_numbers([cues.stage for cues in series], begins)
        upper.plot(x, [cues.ssim for cues in series], "o-", color=COLORS[kind], label=label, alpha=alpha)
        lower.plot(x, [cues.force_size_n for cues in series], "o-", color=COLORS[kind], alpha=alpha)
    upper.set_ylabel("SSIM, mean of both fingers")
    lower.set_ylabel("force of the base [N]")
    lower.set_xticks(list(begins.values()), [stage.value for stage in begins])
    upper.legend(title="base")
    for axes in (upper, lower):
        axes.grid(visible=True, alpha=0.3)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()


def stage_begins(trials: Iterable[Sequence[Cues]]) -> dict[Stage, int]:
    """Number of the first step of each stage that was played, in the stages' order.

    A stage is as long as in the trial that has most steps of it, so that all trials' stages stand below each other.

    Args:
        trials: Series of each.
    """
    most: dict[Stage, int] = {}
    for series in trials:
        counts = Counter(cues.stage for cues in series)
        most |= {stage: max(count, most.get(stage, 0)) for stage, count in counts.items()}
    lengths = [(stage, most[stage]) for stage in Stage if stage in most]
    begins = accumulate((length for _, length in lengths), initial=0)
    return {stage: begin for (stage, _), begin in zip(lengths, begins, strict=False)}


def step_numbers(stages: Sequence[Stage], begins: Mapping[Stage, int]) -> list[int]:
    """Where each step of one trial is drawn: a step after the one before, each stage from its own beginning on.

    Args:
        stages: Stage of each step, in the order in which they were played.
        begins: From `stage_begins`.
    """
    seen: Counter[Stage] = Counter()
    places = []
    for stage in stages:
        places.append(begins[stage] + seen[stage])
        seen[stage] += 1
    return places
