"""Cost against work: seconds and memory of a warm step for lattices of 5k to 400k unknowns.

Each size runs in a process of its own, so that its peak memory is its own:

    python benchmarks/cost.py --spacing-mm 0.5      # one size, by node spacing; one JSON object
"""

import json
import logging
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar

from laboratory.benchmark import machine, save_figure
from laboratory.deform.methods import sphere_at
from laboratory.deform.problem import repeats_left, sphere_on_block
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError

SCRIPT = Path(__file__).parents[1] / "cost.py"
LOGGER = logging.getLogger(__name__)
SPACINGS_MM = (1.5, 1.0, 0.75, 0.6, 0.5, 0.4, 0.33)
"""Spacings of the uniform block: 4 500 to 400 000 unknowns."""
QUICK_SPACINGS_MM = (1.5, 1.0, 0.75)
START_MM, STEP_MM = 0.75, 0.25
"""The timed step begins at this depth and is this long."""
REPEATS = 5
TOLERANCE_MM = 0.002
PANELS = (
    ("seconds", "warm step of 0.25 mm [s]", "#0072b2"),
    ("seconds_per_iteration", "one Newton iteration [s]", "#009e73"),
    ("memory_mb", "peak memory [MB]", "#d55e00"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CostRow:
    """One size."""

    spacing_mm: float
    unknowns: int
    iterations: int
    """Iterations of the timed step."""
    seconds: float | None
    """Median of the timed step."""
    runs: int
    seconds_per_iteration: float | None
    seconds_setup: float
    """Lattice and analysis of the matrix."""
    memory_mb: float
    """Peak resident memory of the process."""
    outcome: str


def measure_step(spacing_mm: float) -> CostRow:
    """Times the step in this process.

    Args:
        spacing_mm: Node spacing of the uniform block [mm].
    """
    compile_kernels()
    problem = sphere_on_block(f"lattice.spacing_mm={spacing_mm}")
    start = time.perf_counter()
    lattice = build_lattice(problem.design)
    solver = ContactSolver(lattice, tolerance_mm=TOLERANCE_MM)
    setup = time.perf_counter() - start
    seconds: list[float] = []
    iterations, outcome = 0, "solved"
    try:
        before = solver.solve(sphere_at(problem, START_MM - STEP_MM))
        while not seconds or len(seconds) <= repeats_left(seconds[0], REPEATS):
            state = solver.solve(sphere_at(problem, START_MM), before)  # so that the solver comes from there each time
            start = time.perf_counter()
            iterations = solver.solve(sphere_at(problem, START_MM + STEP_MM), state).iterations
            seconds.append(time.perf_counter() - start)
    except ConvergenceError as error:
        outcome = str(error)
    median = float(np.median(seconds)) if seconds else None
    return CostRow(
        spacing_mm=spacing_mm,
        unknowns=3 * lattice.free_nodes,
        iterations=iterations,
        seconds=median,
        runs=len(seconds),
        seconds_per_iteration=median / iterations if median is not None else None,
        seconds_setup=setup,
        memory_mb=_peak_memory_mb(),
        outcome=outcome,
    )


def run_cost(*, quick: bool = False, spacings_mm: Sequence[float] | None = None) -> dict[str, Any]:
    """Measures every size in its own process.

    Args:
        quick: Only the smallest sizes.
        spacings_mm: What to measure instead.

    Returns:
        The object that the plot is drawn from: `results`, `fits`, `machine`.
    """
    rows = []
    for spacing in spacings_mm or (QUICK_SPACINGS_MM if quick else SPACINGS_MM):
        rows.append(_in_own_process(spacing))
        LOGGER.info("%(unknowns)s unknowns: %(seconds)s s, %(memory_mb).0f MB, %(outcome)s", rows[-1])
    return {
        "kind": "cost",
        "quick": quick,
        "results": rows,
        "fits": {
            "seconds": fitted_power(rows, "seconds"),
            "seconds_per_iteration": fitted_power(rows, "seconds_per_iteration"),
            "memory_mb": fitted_power(rows, "memory_mb", offset=True),
        },
        "machine": machine(),
    }


def fitted_power(rows: Sequence[dict[str, Any]], key: str, *, offset: bool = False) -> dict[str, float] | None:
    """Least squares in logarithms: value = `offset` + `factor` times unknowns to the `exponent`.

    Args:
        rows: Results, those without a value left out.
        key: What to fit.
        offset: Whether a part does not depend on the size, as the memory of the program itself; otherwise it is 0.

    Returns:
        None where there are fewer sizes than figures to fit.
    """
    pairs = [(row["unknowns"], row[key]) for row in rows if row[key] is not None]
    if len({unknowns for unknowns, _ in pairs}) < 2 + offset:
        return None
    unknowns, values = np.array(pairs, float).T

    def power(below: float) -> tuple[float, float]:
        exponent, constant = np.polyfit(np.log(unknowns), np.log(values - below), 1)
        return float(exponent), float(np.exp(constant))

    def misfit(below: float) -> float:
        exponent, factor = power(below)
        return float(np.sum(np.log((below + factor * unknowns**exponent) / values) ** 2))

    below = 0.0
    if offset:
        below = float(minimize_scalar(misfit, bounds=(0.0, 0.999 * values.min()), method="bounded").x)
    exponent, factor = power(below)
    return {"exponent": exponent, "factor": factor, "offset": below}


def _in_own_process(spacing_mm: float) -> dict[str, Any]:
    command = [sys.executable, str(SCRIPT), "--spacing-mm", str(spacing_mm)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        found: dict[str, Any] = json.loads(done.stdout)
        return found
    ending = (done.stderr.strip().splitlines() or ["no message"])[-1]
    row = CostRow(
        spacing_mm=spacing_mm, unknowns=0, iterations=0, seconds=None, runs=0, seconds_per_iteration=None,
        seconds_setup=0.0, memory_mb=0.0, outcome=f"ended with {done.returncode}: {ending}",
    )  # fmt: skip
    return asdict(row) | {"memory_mb": None, "unknowns": _unknowns(spacing_mm)}


def _unknowns(spacing_mm: float) -> int:
    return 3 * build_lattice(sphere_on_block(f"lattice.spacing_mm={spacing_mm}").design).free_nodes


def _peak_memory_mb() -> float:
    """Most memory that this process has held [MB]; 0 on Windows, which has no `getrusage`."""
    try:
        import resource
    except ImportError:
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


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
    save_figure(figure, target)
