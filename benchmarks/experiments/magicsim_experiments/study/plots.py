"""Plots of studies, each from its numbers to SVG text."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from magicsim.arrays import Array
from magicsim.report.drawing import BLUE, INK, LINE, ORANGE, WRONG, drawn_panel, plot_style, to_svg
from magicsim_experiments.study.protocol import Row, column_of

COLORS = (LINE, ORANGE, BLUE, WRONG, "#cc79a7", "#009e73", "#999999")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
MOST_TICKS = 8
"""Points of a logarithmic axis that are labelled one by one."""
HEADROOM = 1.05
"""Height of an axis in units of what it would be, so that the highest level is seen."""
_HEIGHT_IN = 3.4
_LINE_IN = 0.1
_PLACE = (0.13, 0.14, 0.85, 0.76)


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """One curve."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float] | None = None
    high: Sequence[float] | None = None
    """Ends of intervals."""
    is_level: bool = False
    """Whether it is one value for all x, drawn as a dashed line across: a baseline."""


def plot_series(
    series: Sequence[Series], *, x_title: str, y_title: str, name: str, label: str, log_x: bool = False,
    from_zero: bool = True,
) -> str:  # fmt: skip
    """Curves with intervals, and levels to compare them with.

    Args:
        series: At least one.
        name: Put before the drawing's identifiers; unique on a page.
        label: What the drawing shows, for a reader who cannot see it.
        log_x: Whether the horizontal axis is logarithmic.
        from_zero: Whether the vertical axis begins at 0.
    """
    with plot_style():
        canvas, panel = _panel(x_title, y_title)
        for place, each in enumerate(series):
            color = COLORS[place % len(COLORS)]
            if each.is_level:
                panel.axhline(each.y[0], color=color, linestyle=(0, (5, 2 + place)), linewidth=1.1, label=each.name)
                continue
            panel.plot(each.x, each.y, color=color, marker=MARKERS[place % len(MARKERS)], ms=4, label=each.name)
            if each.low is not None and each.high is not None:
                panel.fill_between(each.x, each.low, each.high, color=color, alpha=0.18, linewidth=0)
        if log_x:
            panel.set_xscale("log")
            ticks = sorted({value for each in series for value in each.x})
            if 0 < len(ticks) <= MOST_TICKS:
                panel.set_xticks(ticks, [f"{value:.4g}" for value in ticks])
                panel.minorticks_off()
        if from_zero:
            panel.set_ylim(0, HEADROOM * panel.get_ylim()[1])
        panel.legend(loc="best")
        return to_svg(canvas, name=name, label=label)


def plot_answers(truth: Array, answer: Array, *, unit: str, name: str, label: str) -> str:
    """Answers against true values, shape (n,) each, with the line on which they would be right; see `plot_series`."""
    ends = [float(np.min([truth.min(), answer.min()])), float(np.max([truth.max(), answer.max()]))]
    with plot_style():
        canvas, panel = _panel(f"truth [{unit}]", f"answer [{unit}]")
        panel.plot(ends, ends, color=INK, linewidth=0.8, linestyle="--")
        panel.plot(truth, answer, linestyle="none", marker="o", ms=2.6, color=LINE, alpha=0.55, markeredgewidth=0)
        return to_svg(canvas, name=name, label=label)


def plot_intervals(rows: Mapping[str, Row], *, name: str, label: str) -> str:
    """Values of `error` from `low` to `high`, one below the other; what leaves 0 out stands out (see `plot_series`)."""
    values = [column_of(list(rows.values()), key) for key in ("low", "error", "high")]
    with plot_style():
        canvas, panel = drawn_panel(_HEIGHT_IN + _LINE_IN * len(rows), (0.3, 0.06, 0.68, 0.92))
        for place, (low, value, high) in enumerate(zip(*values, strict=True)):
            color = LINE if low <= 0 <= high else ORANGE
            panel.plot([low, value, high], [place] * 3, color=color, linewidth=1.4, marker="o", ms=4, markevery=[1])
        panel.axvline(0, color=INK, linewidth=0.8, linestyle="--")
        panel.set_yticks(range(len(rows)), list(rows))
        panel.invert_yaxis()
        return to_svg(canvas, name=name, label=label)


def _panel(x_title: str, y_title: str) -> tuple[Canvas, Axes]:
    canvas, panel = drawn_panel(_HEIGHT_IN, _PLACE)
    panel.set_xlabel(x_title)
    panel.set_title(y_title, pad=4.0)
    return canvas, panel
