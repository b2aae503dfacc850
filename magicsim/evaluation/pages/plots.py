"""The plots of an evaluation, each from its numbers to SVG text."""

from collections.abc import Mapping, Sequence

import numpy as np

from magicsim.evaluation.statistics.curves import CurvePoint, Roc
from magicsim.report.drawing import drawn_panel, plot_style, to_svg
from magicsim.report.palette import BLUE, FAINT, LINE, ORANGE

_HEIGHT_IN = 3.2
_PLACE = (0.12, 0.15, 0.86, 0.76)


def plot_detection(
    points: Sequence[CurvePoint], *, axis: str, name: str, scored_mm: tuple[float, float], label: str
) -> str:
    """Detection rate by bins of distance or depth, with intervals.

    Args:
        points: One a bin, at least one.
        axis: What the horizontal axis shows, with its unit.
        name: Put before the drawing's identifiers.
        scored_mm: Range whose frames count in the scores, shaded [mm].
        label: What the drawing shows, for a reader who cannot see it.
    """
    middles = np.array([(each.above_mm + each.to_mm) / 2 for each in points])
    halves = np.array([(each.to_mm - each.above_mm) / 2 for each in points])
    rates = np.array([each.rate for each in points])
    lows = np.array([each.rate if each.low is None else each.low for each in points])
    highs = np.array([each.rate if each.high is None else each.high for each in points])
    errors = np.clip(np.stack([rates - lows, highs - rates]), 0, None)
    with plot_style():
        figure, panel = drawn_panel(_HEIGHT_IN, _PLACE)
        panel.axvspan(*scored_mm, color=FAINT, alpha=0.45, linewidth=0, gid="scored")
        panel.errorbar(
            middles, rates, yerr=errors, xerr=halves, linestyle="none", marker="o", ms=4, color=LINE, elinewidth=1.1,
        )  # fmt: skip
        panel.set_ylim(-0.03, 1.03)
        panel.set_xlim(min(0.0, middles[0] - halves[0]), max(middles[-1] + halves[-1], scored_mm[1]))
        panel.set_xlabel(axis)
        panel.set_title("detection rate", pad=4.0)
        return to_svg(figure, name=name, label=label)


def plot_roc(curves: Mapping[str, Roc | None], *, name: str) -> str:
    """ROC curves of approach and touch."""
    with plot_style():
        figure, panel = drawn_panel(_HEIGHT_IN, _PLACE)
        panel.plot([0, 1], [0, 1], color=FAINT, linewidth=0.8)
        for (title, roc), color, style in zip(curves.items(), (BLUE, ORANGE), ("-", "--"), strict=False):
            if roc is not None:
                panel.plot(roc.false_alarms, roc.detections, color=color, linestyle=style, label=title, gid=title)
        panel.set_xlim(-0.02, 1.0)
        panel.set_ylim(0.0, 1.03)
        panel.set_xlabel("share of false alarms")
        panel.set_title("share detected", pad=4.0)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="lower right")
        return to_svg(figure, name=name, label="Trade-off between detections and false alarms")
