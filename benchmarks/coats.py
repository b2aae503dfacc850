"""Forces on coated blocks: the lattice with its membrane against NGSolve with one of its own. JSON on standard output.

    python benchmarks/coats.py

A ball of 4 mm, 0.5 mm deep on a block of 6 x 6 x 4 mm, bare and under coats of 0.05 mm: small, so that a coat counts.
NGSolve needs the extra `reference` (docs/commands/machine.md).
"""

import json
import sys

from laboratory.deform.methods import graded_quarter, solve_lattice
from laboratory.deform.ngsolve_reference import solve_ngsolve
from laboratory.deform.problem import Outcome, sphere_on_block

THICKNESS_MM, DEPTH_MM = 0.05, 0.5
MODULI_MPA, SPACINGS_MM = (0.0, 10.0, 100.0), (1.0, 0.5, 0.25)


def main() -> None:
    """Prints all cases."""
    rows = []
    for modulus in MODULI_MPA:
        coat = f"coat={{kind='opaque',thickness_mm={THICKNESS_MM},modulus_mpa={modulus}}}"
        block = ("footprint_mm=[6,6]", "core_mm=3", *((coat,) if modulus > 0 else ()))
        problem = sphere_on_block(*block).down_to(DEPTH_MM)
        (reference,) = (_force_n(each) for each in solve_ngsolve(problem, 0, elements=4, order=2))
        for spacing in SPACINGS_MM:
            (force,) = (
                _force_n(each)
                for each in solve_lattice(problem, 0, spacing_mm=spacing, tolerance_mm=0.002, build=graded_quarter)
            )
            case = {"thickness_mm": THICKNESS_MM, "modulus_mpa": modulus, "spacing_mm": spacing}
            rows.append(case | {"force_n": force, "reference_n": reference, "error": force / reference - 1})
            sys.stderr.write(f"{rows[-1]}\n")
    sys.stdout.write(json.dumps(rows, indent=1) + "\n")


def _force_n(found: Outcome) -> float:
    """Force at the one depth [N]; an AttributeError where a method has failed."""
    return float(found.force_n)  # type: ignore[union-attr]


if __name__ == "__main__":
    main()
