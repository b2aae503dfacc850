"""What do the detectors need of light, and what does it cost?

    python benchmarks/light.py KIND [KIND ...] --out docs/benchmarks [--quick]

Kinds: `light-cost` (seconds of an image against its size), `verdicts` and `lattice` (which rendering and which lattice
E, C and S need), `blur` (of an edge, by distance), `visibility` (of the grid over the assumed constants), `left-out`
(what every rule that leaves work out saves and changes). Each writes `bench-KIND.json`, and `bench-KIND.png` from it.
"""

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
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

BENCHMARKS = {
    "blur": Benchmark(run=run_blur, plot=plot_blur),
    "lattice": Benchmark(run=run_lattice, plot=plot_lattice),
    "left-out": Benchmark(run=run_left_out, plot=plot_left_out),
    "light-cost": Benchmark(run=run_light_cost, plot=plot_light_cost),
    "verdicts": Benchmark(run=run_verdicts, plot=plot_verdicts),
    "visibility": Benchmark(run=run_visibility, plot=plot_visibility),
}


def main() -> None:
    """Logs each row as it is measured."""
    parser = script_parser(__doc__)
    parser.add_argument("kinds", nargs="+", choices=sorted(BENCHMARKS))
    chosen = parser.parse_args()
    with one_line_errors(parser):
        for kind in chosen.kinds:
            BENCHMARKS[kind].answer(kind, chosen.out, quick=chosen.quick)


if __name__ == "__main__":
    main()
