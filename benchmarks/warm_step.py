"""Time of one warm load step: the default design under a ball, coarse far from the contact and as fine everywhere.

    python benchmarks/warm_step.py

Both lattices run in the same process, so that their ratio holds on a noisy machine; forces are printed beside times.
"""

import json
import statistics
import time

from magicsim.config.models import load_preset
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

STEP_MM, STEPS, REPEATS = 0.25, 6, 5
BALL = parse_object("sphere:radius_mm=4")


def warm_steps(growth: float) -> dict[str, object]:
    """Median seconds of each step to 1.5 mm, and of all of them, after the first."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [f"lattice.growth={growth}"])
    poses = [place_object(BALL, gap_mm=-STEP_MM * (number + 1)) for number in range(STEPS)]
    solver = ContactSolver(build_lattice(design, zone=contact_zone(poses, design)))
    state = solver.solve(poses[0])
    rows = []
    for pose in poses[1:]:
        seconds: list[float] = []
        found: Deformation | None = None
        for _ in range(REPEATS):
            start = time.perf_counter()
            found = solver.solve(pose, state)
            seconds.append(time.perf_counter() - start)
        assert found is not None
        state = found
        rows.append(
            {"force_n": round(float(state.force_n[2]), 4), "iterations": state.iterations,
             "seconds": round(statistics.median(seconds), 3)}
        )  # fmt: skip
    return {
        "growth": growth,
        "unknowns": state.unknowns,
        "median_seconds": statistics.median(float(row["seconds"]) for row in rows),
        "steps": rows,
    }


def main() -> None:
    """Prints one JSON object."""
    compile_kernels()
    print(json.dumps({"step_mm": STEP_MM, "lattices": [warm_steps(growth) for growth in (1.6, 1.0)]}, indent=1))


if __name__ == "__main__":
    main()
