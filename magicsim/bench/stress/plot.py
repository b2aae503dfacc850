"""Draws the stress grid from its JSON and nothing else: a matrix of cases coloured by outcome."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from magicsim.bench.deform.error_plot import save
from magicsim.bench.stress.grid import OUTCOMES

COLORS = ("#4daf7c", "#f2c14e", "#c0392b", "#5b2c6f", "#e08e45", "#d0d0d0")
"""Colours of `OUTCOMES`, in order."""
EMPTY = "#ffffff"
GRID_INCHES, ROW_INCHES = 4.75, 0.19
"""Height of the grid, and of one other path."""


def plot_stress(data: Mapping[str, Any], target: Path) -> None:
    """The grid above, with contrast and Poisson ratio down and object and depth across; all other paths below.

    Args:
        data: What `run_stress` returned, or its file.
        target: PNG or SVG file.
    """
    grid = [row for row in data["results"] if row["group"] == "grid"]
    single = [row for row in data["results"] if row["group"] != "grid"]
    labels = _distinct(row["label"] for row in single)
    heights = GRID_INCHES, 1.5 + ROW_INCHES * len(labels)
    figure = Figure(figsize=(11.5, sum(heights)), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=heights)
    materials = _distinct((row["contrast"], row["poisson_ratio"]) for row in grid)
    places = _distinct((row["label"], row["depth_share"]) for row in grid)
    _matrix(
        above, grid, materials, places,
        lambda row: ((row["contrast"], row["poisson_ratio"]), (row["label"], row["depth_share"])),
    )  # fmt: skip
    above.set_yticks(range(len(materials)), [f"{contrast:g}, {ratio:g}" for contrast, ratio in materials])
    above.set_xticks(range(len(places)), [f"{100 * share:g} %" for _, share in places], rotation=90)
    for number, label in enumerate(_distinct(label for label, _ in places)):
        across = [index for index, (own, _) in enumerate(places) if own == label]
        above.text(float(np.mean(across)), -0.8, label, ha="center", va="bottom", fontsize=9)
        if number:
            above.axvline(across[0] - 0.5, color="#333333", linewidth=1)
    above.set_ylabel("stiffness contrast, Poisson ratio")
    above.set_title(_headline(data["summary"]), pad=24, fontsize=10)
    stages = range(_most_stages(single))
    ordered = [row | {"stage": stage} for row, stage in _numbered(single)]
    _matrix(below, ordered, labels, stages, lambda row: (row["label"], row["stage"]))
    below.set_yticks(range(len(labels)), labels, fontsize=8)
    below.set_xticks([])
    for row in ordered:
        text = f"{100 * row['depth_share']:g} %" + (f", {row['shear_mm']:g} mm" if row["shear_mm"] else "")
        text += f", {row['twist_deg']:g} deg" if row["twist_deg"] else ""
        below.text(row["stage"], labels.index(row["label"]), text, ha="center", va="center", fontsize=8)
    below.set_title("single cases, and ways with friction and on a body that relaxes", fontsize=10)
    handles = [Patch(color=color, label=outcome) for color, outcome in zip(COLORS, OUTCOMES, strict=True)]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
    save(figure, target)


def _matrix(panel: Axes, rows: Sequence[Mapping[str, Any]], down: Sequence[Any], across: Sequence[Any], key: Any) -> None:  # noqa: ANN401, E501  # fmt: skip
    image = np.full((max(1, len(down)), max(1, len(across))), len(OUTCOMES))
    for row in rows:
        first, second = key(row)
        image[list(down).index(first), list(across).index(second)] = OUTCOMES.index(row["outcome"])
    norm = BoundaryNorm(np.arange(-0.5, len(OUTCOMES) + 1), len(OUTCOMES) + 1)
    edges = [np.arange(size + 1) - 0.5 for size in image.shape[::-1]]
    panel.pcolormesh(*edges, image, cmap=ListedColormap([*COLORS, EMPTY]), norm=norm, edgecolors="white", linewidth=1)
    panel.invert_yaxis()


def _headline(summary: Mapping[str, Any]) -> str:
    counts = ", ".join(f"{count} {outcome}" for outcome, count in summary["outcomes"].items() if count)
    share = summary["valid_share"]
    judged = "" if share is None else f"; {100 * share:.1f} % of {summary['judged']} valid up to half of the height"
    return f"{summary['cases']} cases: {counts}{judged}"


def _distinct(values: Any) -> list[Any]:  # noqa: ANN401
    """Values in order of first appearance."""
    return list(dict.fromkeys(values))


def _numbered(rows: Sequence[Mapping[str, Any]]) -> list[tuple[dict[str, Any], int]]:
    """Rows with their place in their own path."""
    seen: dict[str, int] = {}
    numbered = []
    for row in rows:
        seen[row["label"]] = seen.get(row["label"], -1) + 1
        numbered.append((dict(row), seen[row["label"]]))
    return numbered


def _most_stages(rows: Sequence[Mapping[str, Any]]) -> int:
    return max((stage for _, stage in _numbered(rows)), default=0) + 1
