"""How noisy is the light at which run time, beside Mitsuba's `volpath`, and do both have the same mean?

    python benchmarks/render.py --out docs/benchmarks [--quick]
    python benchmarks/render.py rest                            # one state in this process; one JSON object
    python benchmarks/render.py pressed --first-seed 101        # the same with other random numbers
    python benchmarks/render.py gelsight-type --samples 16      # both methods compared on another scene's first frame,
                                                                # in a small image
Without a state it writes `bench-render.json`, and `bench-render.png` from it.
"""

import json

from laboratory.benchmark import Benchmark, one_line_errors, script_parser
from laboratory.light.plots import plot_render
from laboratory.light.render import both, measure_state, run_render


def main() -> None:
    """Logs each setting as it is rendered."""
    parser = script_parser(__doc__)
    parser.add_argument("state", nargs="?", help="name of a scene")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--samples", type=int, help="compare both methods alone, with so many samples a pixel")
    parser.add_argument("--set", action="append", default=[], help="dotted.key=value of the scene")
    chosen = parser.parse_args()
    with one_line_errors(parser):
        if chosen.state is None:
            Benchmark(run=run_render, plot=plot_render).answer("render", chosen.out, quick=chosen.quick)
            return
        measured = measure_state(
            chosen.state, quick=chosen.quick, first_seed=chosen.first_seed, overrides=chosen.set,
            only=both(chosen.samples) if chosen.samples is not None else (),
        )  # fmt: skip
        print(json.dumps(measured))


if __name__ == "__main__":
    main()
