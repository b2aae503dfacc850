"""Draws cost against work from the benchmark's JSON and nothing else."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from magicsim.bench.deform.error_plot import save

PANELS = (
    ("seconds", "warm step of 0.25 mm [s]", "#0072b2"),
    ("seconds_per_iteration", "one Newton iteration [s]", "#009e73"),
    ("memory_mb", "peak memory [MB]", "#d55e00"),
)


def plot_cost(data: Mapping[str, Any], target: Path) -> None:
    """Seconds and memory against unknowns, log-log, with the fitted powers.

    Args:
        data: What `run_cost` returned, or its file.
        target: PNG or SVG file.
    """
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    panels = figure.subplots(1, len(PANELS), squeeze=False)[0]
    for panel, (key, title, color) in zip(panels, PANELS, strict=True):
        rows = [row for row in data["results"] if row[key] is not None]
        unknowns = np.array([row["unknowns"] for row in rows], float)
        panel.set(xscale="log", yscale="log" if rows else "linear")
        panel.plot(unknowns, [row[key] for row in rows], "o", color=color, gid=key)
        fit = data["fits"][key]
        if fit is not None:
            sizes = np.geomspace(unknowns.min(), unknowns.max())
            panel.plot(sizes, fit["offset"] + fit["factor"] * sizes ** fit["exponent"], color=color, linewidth=1.2)
            constant = f"{fit['offset']:.0f} + " if fit["offset"] else ""
            law = f"{constant}unknowns to the {fit['exponent']:.2f}"
            panel.text(0.05, 0.92, law, transform=panel.transAxes, va="top")
        failed = [row["unknowns"] for row in data["results"] if row[key] is None]
        panel.plot(
            failed, np.full(len(failed), 0.97), "x", color="#000000", transform=panel.get_xaxis_transform(),
            markeredgewidth=2, gid=f"failed {key}",
        )  # fmt: skip
        panel.set(xlabel="displacement unknowns", title=title)
        panel.grid(visible=True, which="major", color="#e4e4e4", linewidth=0.6)
    save(figure, target)
