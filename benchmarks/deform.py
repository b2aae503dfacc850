"""How close to the truth is the deformation at which run time, beside felupe and NGSolve where they are installed?

    python benchmarks/deform.py --out docs/benchmarks [--quick] [--recompute]

A sphere is pressed into a plain block; errors of force, displacement and contact area are those against a reference of
NGSolve, which `--recompute` solves again. Writes `bench-deform.json`, and `bench-deform.png` from it.
"""

from typing import Any

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
from laboratory.deform.comparison import compare
from laboratory.deform.plot import plot_errors
from laboratory.deform.reference import recompute_reference


def run(*, quick: bool, recompute: bool) -> dict[str, Any]:
    """Runs every method, after the reference where that is asked for."""
    if recompute:
        recompute_reference()
    return compare(quick=quick)


def main() -> None:
    """Logs each row as it is measured."""
    parser = script_parser(__doc__)
    parser.add_argument("--recompute", action="store_true", help="solve the reference again (needs NGSolve)")
    chosen = parser.parse_args()
    with one_line_errors(parser):
        benchmark = Benchmark(run=run, plot=plot_errors)
        benchmark.answer("deform", chosen.out, quick=chosen.quick, recompute=chosen.recompute)


if __name__ == "__main__":
    main()
