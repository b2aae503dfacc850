"""What do the detectors need of light, and what does it cost?

    python benchmarks/light.py KIND [KIND ...] --out docs/benchmarks [--quick]

Kinds: `light-cost` (seconds of an image against its size), `verdicts` and `lattice` (which rendering and which lattice
E, C and S need), `blur` (of an edge, by distance), `visibility` (of the grid over the assumed constants), `left-out`
(what every rule that leaves work out saves and changes). Each writes `bench-KIND.json`, and `bench-KIND.png` from it.
"""

import argparse
import json
import logging
from pathlib import Path
from typing import Any

from laboratory.light.kinds import LIGHT_BENCHMARKS, draw_light

from magicsim.folder import result_file


def run(kind: str, out: Path, *, quick: bool) -> dict[str, Any]:
    """Answers one question; `out` then holds its figures and its plot."""
    data = LIGHT_BENCHMARKS[kind].run(quick=quick)
    file = out / f"bench-{kind}.json"
    with result_file(file) as partial:
        partial.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    draw_light(file, out / f"bench-{kind}.png")
    return data


def main() -> None:
    """Prints each row as it is measured."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="+", choices=sorted(LIGHT_BENCHMARKS))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true", help="a small part of it")
    chosen = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    logging.getLogger("laboratory").setLevel(logging.INFO)
    for kind in chosen.kinds:
        run(kind, chosen.out, quick=chosen.quick)


if __name__ == "__main__":
    main()
