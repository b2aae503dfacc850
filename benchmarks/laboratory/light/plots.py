"""Draws the benchmarks of light from their JSON and nothing else: error against run time, blur, rules."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from laboratory.benchmark import save_figure

STYLES = {
    ("fluence", "llvm_ad_rgb"): ("#0072b2", "o", "fluence"),
    ("anchored", "llvm_ad_rgb"): ("#009e73", "D", "fluence, a frame of an episode"),
    ("path", "llvm_ad_rgb"): ("#d55e00", "s", "volpath"),
    ("path", "scalar_rgb"): ("#888888", "^", "volpath, scalar"),
}
"""Colour, marker and name by estimator and variant."""


def plot_render(data: Mapping[str, Any], target: Path) -> None:
    """Log-log relative error against seconds of an image, one panel a state; volpath extrapolated by a dashed line.

    Args:
        data: What `run_render` returned, or its file.
        target: PNG or SVG file.
    """
    states = list(dict.fromkeys(row["state"] for row in data["results"]))
    figure = Figure(figsize=(max(4.5, 3.4 * len(states)), 3.9), layout="constrained")
    panels = figure.subplots(1, len(states), squeeze=False, sharey=True)[0]
    lowest = min(row["error"] for row in data["results"])
    for panel, state in zip(panels, states, strict=True):
        panel.set(xscale="log", yscale="log", title=state, xlabel="seconds of an image")
        for (estimator, variant), (color, marker, name) in STYLES.items():
            rows = [
                row for row in data["results"]
                if (row["state"], row["estimator"], row["variant"]) == (state, estimator, variant)
            ]  # fmt: skip
            if not rows:
                continue
            seconds, errors = (np.array([row[key] for row in rows]) for key in ("seconds", "error"))
            panel.errorbar(
                seconds, errors, yerr=[row["error_of_error"] for row in rows],
                color=color, marker=marker, markersize=4, linewidth=1.2, label=name,
            )  # fmt: skip
            if estimator == "path" and errors[-1] > lowest:
                longer = (errors[-1] / lowest) ** 2
                panel.plot([seconds[-1], seconds[-1] * longer], [errors[-1], lowest], "--", color=color, linewidth=1)
        panel.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.6)
    panels[0].set_ylabel("relative root mean square error")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5, frameon=False)
    save_figure(figure, target)


COLORS = ("#222222", "#d55e00", "#e69f00", "#0072b2", "#009e73", "#cc79a7")


def plot_blur(data: Mapping[str, Any], target: Path) -> None:
    """Modulation transfer against frequency, one panel a distance."""
    rows, frequencies = data["results"], data["frequencies_per_mm"]
    figure, panels = _panels(_distinct(rows, "gap_mm"))
    for panel, gap in zip(panels, _distinct(rows, "gap_mm"), strict=True):
        for color, method in zip(COLORS, _distinct(rows, "method"), strict=False):
            row = next(row for row in rows if (row["gap_mm"], row["method"]) == (gap, method))
            panel.errorbar(
                frequencies, row["transfer"], yerr=row["error"], color=color, marker="o", markersize=3, label=method
            )
        panel.set(xscale="log", title=f"edge at {gap:g} mm", xlabel="cycles per mm")
        panel.set_xticks(frequencies, [f"{each:g}" for each in frequencies])
        panel.minorticks_off()
    panels[0].set_ylabel("modulation transfer")
    _finish(figure, panels, target)


def plot_left_out(data: Mapping[str, Any], target: Path) -> None:
    """Seconds with and without each rule, one row a rule, with what it changes."""
    rows = data["results"]
    figure = Figure(figsize=(12, 0.55 * len(rows) + 1.4), layout="constrained")
    axes = figure.subplots()
    for place, row in enumerate(rows):
        axes.plot([row["seconds"], row["seconds_full"]], [place, place], color="#bbbbbb", linewidth=1)
        axes.plot(row["seconds_full"], place, "o", color=COLORS[1], label="everything done" if place == 0 else None)
        axes.plot(row["seconds"], place, "o", color=COLORS[3], label="with the rule" if place == 0 else None)
        noise = "" if row["noise"] is None else f", noise {row['noise']:.2g}"
        axes.annotate(f"{row['result']}: changes {row['difference']:.2g}{noise}", (row["seconds_full"], place),
                      xytext=(8, 0), textcoords="offset points", va="center", fontsize=8)  # fmt: skip
    axes.set(xscale="log", xlabel="seconds", yticks=range(len(rows)), ylim=(len(rows) - 0.4, -0.6))
    axes.set_yticklabels([row["rule"] for row in rows])
    axes.set_xlim(right=200 * max(row["seconds_full"] for row in rows))
    _finish(figure, [axes], target)


def _distinct(rows: Sequence[Mapping[str, Any]], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _panels(names: Sequence[Any]) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(max(4.5, 3.3 * len(names)), 3.6), layout="constrained")
    return figure, list(np.ravel(figure.subplots(1, len(names), squeeze=False)))


def _finish(figure: Figure, panels: Sequence[Axes], target: Path) -> None:
    for panel in panels:
        panel.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.6)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(handles), fontsize=8.5, frameon=False)
    save_figure(figure, target)
