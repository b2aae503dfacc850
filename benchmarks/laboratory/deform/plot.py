"""Draws error against run time from the benchmark's JSON and nothing else."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from laboratory.benchmark import save_figure
from laboratory.deform.problem import NOT_INSTALLED, SOLVED

MEASURES = (
    ("error", "force_error", "force: relative error"),
    ("error_displacement", None, "surface displacement: relative RMS error"),
    ("error_area", "area_error", "contact area: relative error"),
)
"""Key of a row, key of the reference's own error, title."""
COLORS = (
    "#0072b2", "#56b4e9", "#009e73", "#8fd694", "#d55e00", "#e69f00", "#cc79a7", "#7f3c8d", "#444444", "#a0a0a0",
    "#8c510a", "#d7301f",
)  # fmt: skip
"""Okabe and Ito (Color Universal Design, 2008), extended."""
MARKERS = "osD^vP*Xph<>"
LEAST_ERROR = 1e-5
"""Smaller ones are below the reference's own and are not drawn."""


def plot_errors(data: Mapping[str, Any], target: Path) -> None:
    """Log-log error against the seconds of a warm step: a row of panels for each measure, a column for each depth.

    A failure is a cross on the upper edge, at the time that was spent on it.

    Args:
        data: What `compare` returned, or its file.
        target: PNG or SVG file.
    """
    rows = [row for row in data["results"] if row["outcome"] != NOT_INSTALLED]
    depths = sorted({row["depth_mm"] for row in rows})
    methods = list(dict.fromkeys(row["method"] for row in rows))
    figure = Figure(figsize=(max(9.0, 4.2 * len(depths)), 9.6), layout="constrained")
    panels = figure.subplots(len(MEASURES), max(1, len(depths)), squeeze=False, sharex=True, sharey="row")
    own = {depth["depth_mm"]: depth for depth in data["reference"]["depths"]}
    for line, (key, own_key, title) in zip(panels, MEASURES, strict=True):
        for panel, depth in zip(line, depths, strict=True):
            panel.set(xscale="log", yscale="log")
            for number, method in enumerate(methods):
                curve = [row for row in rows if row["method"] == method and row["depth_mm"] == depth]
                _draw(panel, curve, key, method, number)
            if own_key is not None and depth in own:
                panel.axhspan(1e-6, max(own[depth][own_key], 1e-6), color="#dddddd", zorder=0)
            panel.set_title(f"{title}, {depth:g} mm deep", fontsize=8.5)
            panel.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.6)
        line[0].set_ylim(*_limits(rows, key))
    for panel in panels[-1]:
        panel.set_xlabel("seconds of a warm step" + (" of 0.25 mm" if data["step_mm"] == 0.25 else ""))
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5, frameon=False)
    save_figure(figure, target)


def _draw(panel: Axes, curve: Sequence[Mapping[str, Any]], key: str, method: str, number: int) -> None:
    color, marker = COLORS[number % len(COLORS)], MARKERS[number % len(MARKERS)]
    solved = [row for row in curve if row["outcome"] == SOLVED]
    panel.plot(
        [row["seconds"] for row in solved], [row[key] for row in solved],
        color=color, marker=marker, markersize=5, linewidth=1.2, label=method, gid=method,
    )  # fmt: skip
    failed = [row["seconds_total"] for row in curve if row["outcome"] != SOLVED]
    panel.plot(
        failed, np.full(len(failed), 0.97), "x", color=color, markersize=9, markeredgewidth=2,
        transform=panel.get_xaxis_transform(), gid=f"failed {method}",
    )  # fmt: skip


def _limits(rows: Sequence[Mapping[str, Any]], key: str) -> tuple[float, float]:
    values = [row[key] for row in rows if row["outcome"] == SOLVED and row[key] > 0]
    return (max(min(values) / 2, LEAST_ERROR), max(values) * 3) if values else (1e-4, 1.0)
