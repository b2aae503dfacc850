"""Runs the stress grid, in this process or on all cores, counts its outcomes, and draws a matrix of cases.

Each path has a limit of processor seconds; what a killed run has done is kept.
"""

import json
import logging
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from laboratory.benchmark import machine, save_figure
from laboratory.stress.cases import POISSON_RATIOS, StressPath, every_path
from laboratory.stress.grid import (
    CRASHED,
    JUDGED_SHARE,
    NOT_AVAILABLE,
    OUTCOMES,
    TIMED_OUT,
    VALID,
    OutOfProcessorTimeError,
    StressRow,
    processor_limit,
    run_path,
    unsolved,
)
from magicsim.deform.indentation.press import compile_kernels
from magicsim.workers.attempt import FailureKind, WorkerOptions, usable_cores
from magicsim.workers.tasks import run_tasks

LOGGER = logging.getLogger(__name__)
SLOW = frozenset({"sphere 0.5 mm"})
"""Labels of paths that come last: pressed more than its own size deep, the ball takes minutes a stage."""
LIMIT_S = 1200.0
"""Processor time for all stages of one path; what is not done by then counts as not valid."""
STUCK = 20
"""How many times longer a path may take by the clock: it does not compute any more, or not here alone."""
COLORS = ("#4daf7c", "#f2c14e", "#c0392b", "#5b2c6f", "#e08e45", "#d0d0d0")
"""Colours of `OUTCOMES`, in order."""
EMPTY = "#ffffff"
GRID_INCHES, ROW_INCHES = 4.75, 0.19
"""Height of the grid, and of one other path."""


def pooled_rows(chosen: Sequence[StressPath], folder: Path) -> list[StressRow]:
    """Rows of all paths in order.

    Args:
        chosen: Some of `every_path()`.
        folder: Holds one file a path, a line a stage; complete ones are read instead of solved again.
    """
    folder.mkdir(parents=True, exist_ok=True)
    numbers = {path.key: number for number, path in enumerate(every_path())}
    files = [folder / f"{numbers[path.key]:03d}.jsonl" for path in chosen]
    todo = [(path, file) for path, file in zip(chosen, files, strict=True) if len(_read(file)) < len(path.stages)]
    todo.sort(key=lambda each: each[0].label in SLOW)
    options = WorkerOptions(workers=usable_cores(), timeout_s=STUCK * LIMIT_S, retries=0)
    tasks = [(number, (numbers[path.key], str(file), LIMIT_S)) for number, (path, file) in enumerate(todo)]
    for done, outcome in enumerate(run_tasks(_solve, tasks, options, prepare=_use_threads), 1):
        path, file = todo[outcome.key]
        if outcome.failures:
            failure = outcome.failures[-1]
            kind = TIMED_OUT if failure.kind == FailureKind.TIMEOUT else CRASHED
            for stage in path.stages[len(_read(file)) :]:
                _append(file, unsolved(path, stage, kind, failure.message))
        rows = _read(file)
        LOGGER.info(
            "%d of %d: %s, contrast %s, nu %s: %s, %.1f s", done, len(todo), path.label, path.contrast,
            path.poisson_ratio, [row.outcome for row in rows], sum(row.seconds for row in rows),
        )  # fmt: skip
    return [row for file in files for row in _read(file)]


def remove_parts(folder: Path) -> None:
    """Removes the files of all paths, and their folder where it holds nothing else.

    Args:
        folder: What `pooled_rows` was given.
    """
    for number, path in enumerate(every_path()):
        file = folder / f"{number:03d}.jsonl"
        if len(_read(file)) == len(path.stages):
            file.unlink(missing_ok=True)
    with suppress(OSError):  # somebody else's file is in it
        folder.rmdir()


def _use_threads(threads: int) -> None:
    """Processes share the machine best when there is one for each core, with one thread."""
    from magicsim.deform.solve import pardiso

    pardiso.THREADS = threads


def _solve(task: tuple[int, str, float]) -> int:
    """Solves one path into its file within processor seconds; returns the number of stages."""
    path, file, limit_s = every_path()[task[0]], Path(task[1]), task[2]
    file.unlink(missing_ok=True)
    try:
        with processor_limit(limit_s):
            for row in run_path(path):
                _append(file, row)
    except OutOfProcessorTimeError as error:
        for stage in path.stages[len(_read(file)) :]:
            _append(file, unsolved(path, stage, TIMED_OUT, str(error)))
    return len(path.stages)


def _append(file: Path, row: StressRow) -> None:
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")


def _read(file: Path) -> list[StressRow]:
    if not file.exists():
        return []
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    return [StressRow(**json.loads(line)) for line in lines if line.endswith("\n")]


def run_stress(
    *, quick: bool = False, paths: Sequence[StressPath] | None = None, parts: Path | None = None
) -> dict[str, Any]:
    """Runs the grid and the single cases.

    Args:
        quick: Only a fifth of the grid, three of the single cases, and the ways of one sphere.
        paths: What to run instead, in this process.
        parts: Folder for the rows of the paths, from which a killed run goes on; by default they are not kept.

    Returns:
        The object that the plot is drawn from: `results`, `summary`, `machine`.
    """
    compile_kernels()
    if paths is not None:
        rows = [row for path in paths for row in run_path(path)]
    else:
        chosen = [path for path in every_path() if not quick or _is_quick(path)]
        with TemporaryDirectory() as temporary:
            rows = pooled_rows(chosen, parts or Path(temporary))
    return {
        "kind": "stress",
        "quick": quick,
        "results": [asdict(row) for row in rows],
        "summary": summarise(rows),
        "machine": machine(),
    }


def summarise(rows: Iterable[StressRow]) -> dict[str, Any]:
    """Counts of outcomes, and the share that is valid up to half of the height."""
    found = list(rows)
    counts = Counter(row.outcome for row in found)
    judged = [row for row in found if row.depth_share <= JUDGED_SHARE and row.outcome != NOT_AVAILABLE]
    valid = sum(row.outcome == VALID for row in judged)
    return {
        "cases": len(found),
        "outcomes": {outcome: counts[outcome] for outcome in OUTCOMES},
        "judged": len(judged),
        "valid_share": valid / len(judged) if judged else None,
        "seconds": sum(row.seconds for row in found),
    }


def _is_quick(path: StressPath) -> bool:
    if path.group == "single":
        return path.label in {"skin 0.1 mm", "height 1.5 mm", "one step of 50 %"}
    if path.group in {"friction", "relaxing"}:
        return path.label.endswith("sphere 4 mm")
    return path.contrast in {1.0, 1e4} and path.poisson_ratio in {POISSON_RATIOS[0], POISSON_RATIOS[2]}


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
    save_figure(figure, target)


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
