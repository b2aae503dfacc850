"""Forces on coated blocks: the lattice with its membrane against NGSolve with one of its own. JSON on standard output.

    python benchmarks/coats.py > docs/benchmarks/coats.json

A ball of 4 mm on `uniform-block`, 0.5 and 1 mm deep, bare and under coats of 0.05 mm. NGSolve needs the extra
`reference`.
"""

import json
import sys

from magicsim.bench.deform.ngsolve_reference import solve_ngsolve
from magicsim.bench.deform.problem import Failure, sphere_on_block
from magicsim.deform.indentation.press import press
from magicsim.geometry.objects import parse_object

THICKNESS_MM = 0.05
MODULI_MPA = (0.0, 1.0, 10.0, 100.0)
SPACINGS_MM = (1.0, 0.5)
DEPTHS_MM = (0.5, 1.0)
ELEMENTS, ORDER = 6, 2


def main() -> None:
    """Prints all cases."""
    rows, ball = [], parse_object("sphere:radius_mm=4")
    for modulus in MODULI_MPA:
        coat = f"coat={{kind='opaque',thickness_mm={THICKNESS_MM},modulus_mpa={modulus}}}"
        overrides = [coat] if modulus > 0 else []
        problem = sphere_on_block(*overrides).down_to(*DEPTHS_MM)
        for found in solve_ngsolve(problem, 0, elements=ELEMENTS, order=ORDER):
            if isinstance(found, Failure):
                sys.stderr.write(f"{modulus:g} MPa: {found.message}\n")
                continue
            for spacing in SPACINGS_MM:
                design = sphere_on_block(*overrides, f"lattice.spacing_mm={spacing}").design
                ours = press(design, ball, depth_mm=found.depth_mm).force_n[2]
                rows.append(
                    {
                        "thickness_mm": THICKNESS_MM,
                        "modulus_mpa": modulus,
                        "spacing_mm": spacing,
                        "depth_mm": found.depth_mm,
                        "force_n": ours,
                        "reference_n": found.force_n,
                        "error": ours / found.force_n - 1,
                    }
                )
                sys.stderr.write(f"{rows[-1]}\n")
    sys.stdout.write(json.dumps({"elements": ELEMENTS, "order": ORDER, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
