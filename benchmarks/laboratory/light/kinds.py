"""The questions about light, how each is answered, and how its answer is drawn."""

from pathlib import Path

from laboratory.light.blur import run_blur
from laboratory.light.cost import run_light_cost
from laboratory.light.lattice_verdicts import run_lattice
from laboratory.light.left_out import run_left_out
from laboratory.light.plots import (
    plot_blur,
    plot_lattice,
    plot_left_out,
    plot_light_cost,
    plot_verdicts,
    plot_visibility,
)
from laboratory.light.verdicts import run_verdicts
from laboratory.light.visibility import run_visibility
from magicsim.bench.kinds import Benchmark
from magicsim.config.documents import read_json

LIGHT_BENCHMARKS = {
    "blur": Benchmark(run=run_blur, plot=plot_blur),
    "lattice": Benchmark(run=run_lattice, plot=plot_lattice),
    "left-out": Benchmark(run=run_left_out, plot=plot_left_out),
    "light-cost": Benchmark(run=run_light_cost, plot=plot_light_cost),
    "verdicts": Benchmark(run=run_verdicts, plot=plot_verdicts),
    "visibility": Benchmark(run=run_visibility, plot=plot_visibility),
}


def draw_light(file: Path, target: Path) -> None:
    """Draws an answer from its JSON alone.

    Args:
        file: What `benchmarks/light.py` wrote.
        target: PNG or SVG file.
    """
    data = read_json(file)
    LIGHT_BENCHMARKS[data["kind"]].plot(data, target)
