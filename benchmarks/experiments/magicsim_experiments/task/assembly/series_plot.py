"""SSIM against time, the force labels below it; lines are where stages end in most trials, by their letters."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from magicsim_experiments.assembly.cues import Cues
from magicsim_experiments.assembly.misaligned import Misalignment
from magicsim_experiments.assembly.stages import Stage

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
    told, alpha = set(), 0.7 if len(trials) < MANY else 0.3
    for misalignment, series in trials:
        kind = misalignment.kind
        label = kind if kind not in told else None
        told.add(kind)
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
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()


def stage_ends_s(trials: Sequence[Sequence[Cues]]) -> dict[Stage, float]:
    """When each stage that was played ends, the median over trials [s].

    Args:
        trials: Series of each.
    """
    lasts: dict[Stage, list[float]] = {}
    for series in trials:
        for stage, last in {cues.stage: cues.time_s for cues in series}.items():
            lasts.setdefault(stage, []).append(last)
    return {stage: float(np.median(lasts[stage])) for stage in Stage if stage in lasts}
