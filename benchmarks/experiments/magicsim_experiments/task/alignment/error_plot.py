"""Error against time of all episodes, and how well each finger read the angle."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from magicsim_experiments.task.alignment.episode import FrameRow
from magicsim_experiments.task.alignment.outcome import READERS, Outcome

COLORS = {"seen": "tab:blue", "unseen": "tab:orange"}
LIMIT = "tab:green"
AROUND_DEG = 5.0
"""Room beside the true angles, which hardly differ within an episode [degrees]."""


def draw_errors(
    outcomes: Sequence[Outcome], rows: Sequence[FrameRow], *, unseen: Sequence[str], within_deg: float
) -> bytes:
    """A PNG: above, each episode's error against time with the median of each group; below, errors of the readings.

    Args:
        outcomes: All episodes.
        rows: All their frames.
        unseen: Items that are drawn apart.
        within_deg: Limit that is drawn as a band [degrees].
    """
    figure = Figure(figsize=(8, 6.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=[3, 2])
    upper.axhspan(-within_deg, within_deg, color=LIMIT, alpha=0.15, linewidth=0)
    for group, color in COLORS.items():
        numbers = [each.episode for each in outcomes if (each.item in unseen) == (group == "unseen")]
        series = {number: [row for row in rows if row.episode == number] for number in numbers}
        drawn = [each for each in series.values() if each]
        for each in drawn:
            upper.plot([row.time_s for row in each], [row.error_deg for row in each], color=color, alpha=0.35, lw=1)
        if drawn:
            times = sorted({row.time_s for each in drawn for row in each})
            sizes = [[abs(row.error_deg) for each in drawn for row in each if row.time_s == time] for time in times]
            middle = [float(np.median(each)) for each in sizes]
            upper.plot(times, middle, "o-", color=color, ms=3, label=f"median size, {group} items ({len(drawn)})")
    upper.axhline(0, color="0.4", lw=0.8)
    upper.set_ylabel("axis to the vertical [degrees]")
    upper.legend()
    found = [np.array([getattr(row, column) - row.held_deg for row in rows]) for column in READERS.values()]
    truth = [row.held_deg for row in rows]
    for name, errors in zip(READERS, found, strict=True):
        lower.plot(truth, errors, "o", ms=3, alpha=0.5, label=name)
    lower.axhline(0, color="0.4", lw=0.8)
    if truth:
        lower.set_xlim(min(truth) - AROUND_DEG, max(truth) + AROUND_DEG)
    lower.set_ylabel("read less true [degrees]")
    lower.legend()
    for axes, title in ((upper, "time [s]"), (lower, "true angle in the grip [degrees]")):
        axes.set_xlabel(title)
        axes.grid(visible=True, alpha=0.3)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()
