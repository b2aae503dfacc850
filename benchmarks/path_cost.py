"""What a step of a path costs: processor time, iterations and factorisations of presses, drags and a live controller.

    OMP_NUM_THREADS=1 python benchmarks/path_cost.py

The default design under a ball of radius 4 mm. Processor time on one core is what holds on a busy machine; with a
second one the factorisations, half of it, take half as long.
"""

import json
import statistics
import time

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")
STEPS = 8


def path(first_mm: float, deeper_mm: float = 0.0, along_mm: float = 0.0) -> list[Indenter]:
    """Poses of even steps from a depth, the start among them."""
    return [
        place_object(BALL, gap_mm=-first_mm - deeper_mm * number, x_mm=along_mm * number) for number in range(STEPS + 1)
    ]


PATHS = {
    "press in steps of 0.25 mm": (0.0, path(0.25, 0.25)),
    "press in steps of 0.1 mm, friction 0.6": (0.6, path(0.1, 0.1)),
    "press in steps of 0.03 mm, friction 0.6": (0.6, path(0.5, 0.03)),
    "drag at 0.8 mm in steps of 0.1 mm, friction 0.6": (0.6, path(0.8, along_mm=0.1)),
    "drag at 0.8 mm in steps of 0.0001 mm, friction 0.6": (0.6, path(0.8, along_mm=1e-4)),
}


def measured(friction: float, poses: list[Indenter]) -> dict[str, float]:
    """Medians and means over the steps after the first."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [])
    solver = ContactSolver(build_lattice(design, zone=contact_zone(poses, design)), friction=friction)
    state = solver.solve(poses[0])
    before, seconds, iterations = getattr(solver, "factorisations", 0), [], 0
    for pose in poses[1:]:
        start = time.process_time()
        state = solver.solve(pose, state)
        seconds.append(time.process_time() - start)
        iterations += state.iterations
    return {
        "unknowns": state.unknowns,
        "median_cpu_seconds": round(statistics.median(seconds), 3),
        "iterations_a_step": iterations / STEPS,
        "factorisations_a_step": (getattr(solver, "factorisations", 0) - before) / STEPS,
        "last_force_n": round(float(state.force_n[2]), 4),
    }


def main() -> None:
    """Prints one JSON object."""
    compile_kernels()
    print(json.dumps({name: measured(*each) for name, each in PATHS.items()}, indent=1))


if __name__ == "__main__":
    main()
