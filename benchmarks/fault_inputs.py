"""Inputs and surroundings that once gave a wrong answer and said nothing: the right value, or one line that names it.

    python benchmarks/fault_inputs.py
    python benchmarks/fault_inputs.py "mesh"

runs every kind (or those whose name holds a word), three variations each, and writes the table of the documentation
(docs/benchmarks/fault-inputs.csv). The exit code is 1 where an answer is another one.
"""

import argparse
import csv
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from laboratory import input_kinds
from laboratory.input_kinds.registry import KINDS

TABLE = Path("docs/benchmarks/fault-inputs.csv")


def register() -> None:
    """Imports every module of kinds."""
    for module in sorted(each.name for each in iter_modules(input_kinds.__path__)):
        import_module(f"{input_kinds.__name__}.{module}")


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("word", nargs="?", default="", help="part of the kinds' names")
    parser.add_argument("--out", type=Path, default=TABLE)
    chosen = parser.parse_args()
    register()
    rows = [["kind", "variation", "expected", "holds"]]
    for kind, variations in KINDS.items():
        for each in variations if chosen.word in kind else ():
            with tempfile.TemporaryDirectory() as work:
                try:
                    wrong = each.attempt(Path(work))
                except Exception as error:  # a kind counts as wrong, and the others are tried
                    wrong = f"{type(error).__name__}: {error}"
            rows.append([kind, each.name, each.expected, "no" if wrong else "yes"])
            print(f"{'no ' if wrong else 'yes'} {kind}: {each.name}{f': {wrong}' if wrong else ''}", flush=True)
    if not chosen.word:
        with chosen.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    sys.exit(any(row[-1] == "no" for row in rows[1:]))


if __name__ == "__main__":
    main()
