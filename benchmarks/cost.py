"""What do seconds and memory of a warm step cost, for lattices of 5k to 400k unknowns?

    python benchmarks/cost.py --out docs/benchmarks [--quick]
    python benchmarks/cost.py --spacing-mm 0.5      # one size in this process; one JSON object

Writes `bench-cost.json`, and `bench-cost.png` from it.
"""

import json
from dataclasses import asdict

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
from laboratory.cost import measure_step, plot_cost, run_cost


def main() -> None:
    """Logs each size as it is measured."""
    parser = script_parser(__doc__)
    parser.add_argument("--spacing-mm", type=float, help="measure one node spacing alone")
    chosen = parser.parse_args()
    with one_line_errors(parser):
        if chosen.spacing_mm is not None:
            print(json.dumps(asdict(measure_step(chosen.spacing_mm))))
        else:
            Benchmark(run=run_cost, plot=plot_cost).answer("cost", chosen.out, quick=chosen.quick)


if __name__ == "__main__":
    main()
