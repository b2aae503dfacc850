"""Draws error against run time of the light from the benchmark's JSON and nothing else."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from magicsim.bench.deform.error_plot import save

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
    save(figure, target)
