"""Forces on domes: the mapped lattice against NGSolve on the curved body. JSON on standard output.

    python benchmarks/domes.py > docs/benchmarks/domes.json
    python benchmarks/domes.py cylinder plate --elements 8     # one case with finer elements

A ball of 4 mm and a plate on the crown of a sphere and of a cylinder, 0.5 and 1 mm deep: the block of `uniform-block`
with a dome. The reference's plate is a ball of 20 m. NGSolve needs the extra `reference` (docs/commands/machine.md).
"""

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace

from laboratory.deform.ngsolve_reference import solve_ngsolve
from laboratory.deform.problem import Failure, sphere_on_block

from magicsim.deform.indentation.press import press
from magicsim.geometry.objects import parse_object

FACES = {
    "sphere": 'face={kind="dome",radius_x_mm=30,radius_y_mm=30,crown_mm=2.5,rim_mm=0}',
    "cylinder": 'face={kind="dome",radius_x_mm=25,crown_mm=3.5,rim_mm=0}',
}
OBJECTS = {"ball": ("sphere:radius_mm=4", 4.0, 0.5), "plate": ("box:size_mm=[60,60,10]", 2e4, 1.0)}
"""What presses, radius of the reference's ball [mm], and node spacing [mm]: a small contact needs a finer lattice."""
DEPTHS_MM = (0.5, 1.0)
ELEMENTS, ORDER = 6, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One press."""

    face: str
    object: str
    depth_mm: float
    force_n: float
    reference_n: float
    error: float
    """Relative."""
    spacing_mm: float
    reference_unknowns: int


def compared(face: str, name: str, elements: int) -> Iterator[Row]:
    """One object on one face, at every depth.

    Args:
        face: Of `FACES`.
        name: Of `OBJECTS`.
        elements: Of the reference, across half the contact at the deepest depth.
    """
    line, radius, spacing = OBJECTS[name]
    block = sphere_on_block(FACES[face], f"lattice.spacing_mm={spacing:g}")
    problem = replace(block, radius_mm=radius, depths_mm=DEPTHS_MM)
    pressed = parse_object(line)
    for found in solve_ngsolve(problem, 0, elements=elements, order=ORDER):
        if isinstance(found, Failure):
            sys.exit(f"{face}, {name}: {found.message}")
        force = press(problem.design, pressed, depth_mm=found.depth_mm).force_n[2]
        yield Row(
            face=face, object=name, depth_mm=found.depth_mm, force_n=force, reference_n=found.force_n,
            error=force / found.force_n - 1, spacing_mm=spacing, reference_unknowns=found.unknowns,
        )  # fmt: skip


def main() -> None:
    """Prints the cases that are asked for, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("face", nargs="?", choices=FACES)
    parser.add_argument("object", nargs="?", choices=OBJECTS)
    parser.add_argument("--elements", type=int, default=ELEMENTS)
    asked = parser.parse_args()
    rows = []
    for face in [asked.face] if asked.face else FACES:
        for name in [asked.object] if asked.object else OBJECTS:
            for row in compared(face, name, asked.elements):
                sys.stderr.write(f"{row}\n")
                rows.append(asdict(row))
    sys.stdout.write(json.dumps({"elements": asked.elements, "order": ORDER, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
