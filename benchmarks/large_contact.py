"""What presses of long cylinders cost: lying along the face and askew on it, with friction, two depths each.

    python benchmarks/large_contact.py [--only askew]

Seconds are processor time of this process, which other work beside hardly stretches; forces stand beside them. Prints
one JSON object. Two versions of the solver are compared by turns of this script on the trees of both.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

FRICTION = 0.6
CASES: dict[str, tuple[float, float, tuple[float, ...]]] = {
    "along": (7.5, 0.0, (0.3, 1.0)),
    "askew": (7.5, 30.0, (0.15, 0.3)),
    "thin askew": (5.0, 45.0, (0.2, 0.4)),
}
"""Radius [mm], turn about z [degrees] and depths [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """One press of a path."""

    depth_mm: float
    cpu_s: float
    force_n: float
    """Along z."""
    iterations: int
    rungs: tuple[str, ...]
    factorisations: int
    """With the contact condensed, from the path's beginning."""
    points: int
    """In contact."""
    unknowns: int


def pressed(radius_mm: float, turn_deg: float, depths_mm: tuple[float, ...]) -> list[Press]:
    """The default design under a cylinder that lies on it, pressed deeper and deeper."""
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [])
    cylinder = parse_object(f"cylinder:radius_mm={radius_mm},length_mm=100,axis=y")
    poses = [place_object(cylinder, gap_mm=-depth, twist_deg=turn_deg) for depth in depths_mm]
    lattice = build_lattice(design, zone=contact_zone(poses, design))
    solver = ContactSolver(lattice, friction=FRICTION, point_spacing_mm=point_spacing_mm(poses[0].shape))
    state: Deformation | None = None
    found = []
    for depth, pose in zip(depths_mm, poses, strict=True):
        start = time.process_time()
        state = solver.solve(pose, state)
        found.append(
            Press(
                depth_mm=depth, cpu_s=round(time.process_time() - start, 2), force_n=float(state.force_n[2]),
                iterations=state.iterations, rungs=state.rungs, factorisations=solver.factorisations,
                points=int((state.contact_pressure_mpa > 0).sum()), unknowns=state.unknowns,
            )
        )  # fmt: skip
    return found


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=list(CASES))
    chosen = parser.parse_args().only
    compile_kernels()
    cases = {name: pressed(*case) for name, case in CASES.items() if chosen in {None, name}}
    print(json.dumps({name: [asdict(each) for each in presses] for name, presses in cases.items()}, indent=1))


if __name__ == "__main__":
    main()
