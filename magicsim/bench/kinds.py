"""One call for the command line: runs a benchmark, writes its JSON and draws its plot from that file."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from magicsim.bench.cost.plot import plot_cost
from magicsim.bench.cost.steps import run_cost
from magicsim.bench.deform.compare import compare
from magicsim.bench.deform.error_plot import plot_errors
from magicsim.bench.deform.reference import reference_path
from magicsim.bench.light.render import run_render
from magicsim.bench.light.render_plot import plot_render
from magicsim.bench.stress.benchmark import run_stress
from magicsim.bench.stress.plot import plot_stress
from magicsim.bench.stress.pool import remove_parts
from magicsim.config.documents import read_json
from magicsim.errors import ConfigError, unknown_choice
from magicsim.folder import check_file, result_file


@dataclass(frozen=True, slots=True, kw_only=True)
class Benchmark:
    """A question, how to answer it and how to draw the answer."""

    run: Callable[..., dict[str, Any]]
    """Takes `quick`; returns an object with `results`."""
    plot: Callable[[dict[str, Any], Path], None]


BENCHMARKS = {
    "deform": Benchmark(run=compare, plot=plot_errors),
    "stress": Benchmark(run=run_stress, plot=plot_stress),
    "cost": Benchmark(run=run_cost, plot=plot_cost),
    "render": Benchmark(run=run_render, plot=plot_render),
}


def run_bench(kind: str, out: Path, *, quick: bool = False, recompute: bool = False) -> dict[str, Any]:
    """Runs one benchmark; `out` then holds `bench-KIND.json` and `bench-KIND.png`.

    Args:
        kind: `deform` and `render` (error against run time), `stress` (validity at extremes), `cost` (of a step against
            the size of the lattice), or `all`, one after the other.
        out: Folder, made where missing.
        quick: A small part of it, in a minute or two.
        recompute: Solve the reference of `deform` again first, and replace its file (needs NGSolve).

    Returns:
        The object in the file: `results` and what belongs to them.

    Raises:
        ConfigError: An unknown kind, or NGSolve is missing where it is needed.
        PresetError: There is no reference.
        OutputError: The folder cannot be written; that is told before anything is measured.
    """
    if kind == "all":
        found = [run_bench(each, out, quick=quick, recompute=recompute) for each in BENCHMARKS]
        return {"kind": "all", "results": [{"kind": one["kind"], **row} for one in found for row in one["results"]]}
    if kind not in BENCHMARKS:
        raise ConfigError(unknown_choice("benchmark", kind, BENCHMARKS))
    file = out / f"bench-{kind}.json"
    check_file(file)
    if recompute and kind == "deform":
        _recompute()
    parts = out / "stress-parts"
    data = BENCHMARKS[kind].run(quick=quick, **({"parts": parts} if kind == "stress" else {}))
    with result_file(file) as partial:
        partial.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    draw(file, out / f"bench-{kind}.png")
    if kind == "stress":
        remove_parts(parts)  # kept for a killed run alone: another run measures again
    return data


def draw(file: Path, target: Path) -> None:
    """Draws a benchmark from its JSON alone.

    Args:
        file: What `run_bench` wrote.
        target: PNG or SVG file.
    """
    data = read_json(file)
    BENCHMARKS[data["kind"]].plot(data, target)


def _recompute() -> None:
    try:
        from magicsim.bench.deform.recompute import recompute_reference
    except ImportError as error:
        msg = f"recompute needs NGSolve, `pip install magicsim[reference]`: {error}"
        raise ConfigError(msg) from None
    recompute_reference(reference_path())
