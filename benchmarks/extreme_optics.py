"""White furnace and energy balance of extreme sensors: one table, one row a case.

python benchmarks/extreme_optics.py [CASE ...] [--out FILE.json]
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from laboratory.light.optics import CASES, check_optics

from magicsim.errors import MagicsimError


def main() -> None:
    """Prints every case as it is done, and writes the rows."""
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    rows = []
    for case in chosen.cases:
        try:
            row = asdict(check_optics(case))
            figures = [f"{key} {value:+.4f}" for key, value in row.items() if isinstance(value, float)]
            print(f"{case}: {'finite' if row['is_finite'] else 'NOT FINITE'}, {', '.join(figures)}", flush=True)
        except MagicsimError as error:
            row = {"case": case, "declared": str(error)}
            print(f"{case}: declared: {error}", flush=True)
        rows.append(row)
        if chosen.out is not None:
            chosen.out.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
