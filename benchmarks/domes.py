"""Forces on domes: the mapped lattice against NGSolve on the curved body. JSON on standard output.

    python benchmarks/domes.py > docs/benchmarks/domes.json

A ball and nearly a plate (a ball of 200 mm) on the crown of a sphere and of a cylinder, at 0.5 and 1 mm: the block
of `uniform-block` with a dome. NGSolve needs the extra `reference`.
"""

import json
import sys

from magicsim.bench.deform.ngsolve_reference import solve_ngsolve
from magicsim.bench.deform.problem import Failure, sphere_on_block
from magicsim.deform.indentation.press import press
from magicsim.geometry.objects import parse_object

FACES = {
    "sphere": 'face={kind="dome",radius_x_mm=30,radius_y_mm=30,crown_mm=2.5,rim_mm=0}',
    "cylinder": 'face={kind="dome",radius_x_mm=25,crown_mm=3.5,rim_mm=0}',
}
BALLS_MM = (4.0, 200.0)
DEPTHS_MM = (0.5, 1.0)
ELEMENTS, ORDER = 6, 2


def main() -> None:
    """Prints all cases."""
    rows = []
    for name, face in FACES.items():
        for radius in BALLS_MM:
            from dataclasses import replace

            problem = replace(sphere_on_block(face), radius_mm=radius, depths_mm=DEPTHS_MM)
            for found in solve_ngsolve(problem, 0, elements=ELEMENTS, order=ORDER):
                if isinstance(found, Failure):
                    sys.stderr.write(f"{name} {radius:g}: {found.message}\n")
                    continue
                ball = parse_object(f"sphere:radius_mm={radius:g}")
                ours = press(problem.design, ball, depth_mm=found.depth_mm).force_n[2]
                rows.append(
                    {
                        "face": name,
                        "ball_mm": radius,
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
