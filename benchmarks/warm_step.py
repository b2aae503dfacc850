"""Time of one warm load step: the default design under a ball, coarse far from the contact and as fine everywhere.

    python benchmarks/warm_step.py

The path is walked several times by one solver: a step begins where the last one ended. Both lattices run in the same
process, so that their ratio holds on a noisy machine; forces are printed beside times.
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
    """Median seconds of each step of a path to 1.5 mm, and of all of them, after the first."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [f"lattice.growth={growth}"])
    poses = [place_object(BALL, gap_mm=-STEP_MM * (number + 1)) for number in range(STEPS)]
    solver = ContactSolver(build_lattice(design, zone=contact_zone(poses, design)))
    seconds: list[list[float]] = [[] for _ in poses]
    states: list[Deformation] = []
    for _ in range(REPEATS):
        states = []
        for number, pose in enumerate(poses):
            start = time.perf_counter()
            states.append(solver.solve(pose, states[-1] if states else None))
            seconds[number].append(time.perf_counter() - start)
    rows = [
        {"force_n": round(float(state.force_n[2]), 4), "iterations": state.iterations,
         "seconds": round(statistics.median(each), 3)}
        for state, each in zip(states[1:], seconds[1:], strict=True)
    ]  # fmt: skip
    return {
        "growth": growth,
        "unknowns": states[-1].unknowns,
        "median_seconds": statistics.median(float(row["seconds"]) for row in rows),
        "steps": rows,
    }


def main() -> None:
    """Prints one JSON object."""
    compile_kernels()
    print(json.dumps({"step_mm": STEP_MM, "lattices": [warm_steps(growth) for growth in (1.6, 1.0)]}, indent=1))


if __name__ == "__main__":
    main()
