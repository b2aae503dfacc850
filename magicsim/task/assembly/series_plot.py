"""SSIM against the stages, with the force labels beside it."""

import io
from collections.abc import Sequence

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
    places = {stage: number for number, stage in enumerate(Stage)}
    told, alpha = set(), 0.7 if len(trials) < MANY else 0.3
    for misalignment, series in trials:
        kind = misalignment.kind
        label = kind if kind not in told else None
        told.add(kind)
        x = [places[cues.stage] for cues in series]
        upper.plot(x, [cues.ssim for cues in series], "o-", color=COLORS[kind], label=label, alpha=alpha)
        lower.plot(x, [cues.force_size_n for cues in series], "o-", color=COLORS[kind], alpha=alpha)
    upper.set_ylabel("SSIM, mean of both fingers")
    lower.set_ylabel("force of the base [N]")
    lower.set_xticks(list(places.values()), [stage.value for stage in places])
    upper.legend(title="base")
    for axes in (upper, lower):
        axes.grid(visible=True, alpha=0.3)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()
