"""Where is the deformation valid, refused or silently wrong at extremes: contrast, Poisson ratio, depth, friction?

    python benchmarks/stress.py --out docs/benchmarks [--quick]

Every path is solved on all cores within its processor time, and every state is verified without asking the solver. A
killed run goes on where it stopped. Writes `bench-stress.json`, and `bench-stress.png` from it.
"""

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
from laboratory.stress.benchmark import plot_stress, remove_parts, run_stress


def main() -> None:
    """Logs each path as it is solved."""
    parser = script_parser(__doc__)
    chosen = parser.parse_args()
    parts = chosen.out / "stress-parts"
    with one_line_errors(parser):
        Benchmark(run=run_stress, plot=plot_stress).answer("stress", chosen.out, quick=chosen.quick, parts=parts)
    remove_parts(parts)  # kept for a killed run alone: another run measures again


if __name__ == "__main__":
    main()
