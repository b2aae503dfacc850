"""How blurred is an edge, by distance, and what do the rules save and change that leave work out?

    python benchmarks/light.py KIND [KIND ...] --out docs/benchmarks [--quick]

Kinds: `blur` and `left-out`. Each writes `bench-KIND.json`, and `bench-KIND.png` from it.
"""

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
from laboratory.light.blur import run_blur
from laboratory.light.left_out import run_left_out
from laboratory.light.plots import plot_blur, plot_left_out

BENCHMARKS = {
    "blur": Benchmark(run=run_blur, plot=plot_blur),
    "left-out": Benchmark(run=run_left_out, plot=plot_left_out),
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
