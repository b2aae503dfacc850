"""How stretch and stress of the skin, and shear of the infill, depend on the node spacing of the lattice.

    python benchmarks/skin_resolution.py      # a minute; one JSON line for each spacing

A ball of 4 mm radius, 1 mm deep in the middle of the default block, without friction, on quarters of it that are ever
finer; the first line is the lattice that episodes have, the second one such a lattice that is twice as
fine: shear of the infill is told of whole blocks.
"""

import json
import sys

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.spot import central_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import InfillCells, SkinCells
from magicsim.geometry.design import ElastomerDesign, load_design
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

DEPTH_MM, SPACINGS_MM = 1.0, (0.8, 0.4, 0.27, 0.2)
BALL = parse_object("sphere:radius_mm=4")


def figures(design: ElastomerDesign, lattice: Lattice) -> dict[str, float]:
    """Largest values of one press."""
    solver = ContactSolver(lattice, point_spacing_mm=point_spacing_mm(BALL.shape()))
    state = solver.solve(place_object(BALL, gap_mm=-DEPTH_MM))
    skin, cells = SkinCells.of(design, lattice), InfillCells.of(design, lattice)
    fields = skin.fields(state)
    found = {
        "layers": skin.layers,
        "skin_stretch": round(float(fields.stretch.max()), 4),
        "skin_von_mises_mpa": round(float(fields.von_mises_mpa.max()), 4),
        "force_n": round(float(state.force_n[2]) * (4 if lattice.is_mirrored else 1), 4),
    }
    if cells is not None and not lattice.is_mirrored:
        found["infill_shear"] = round(float(cells.shear(state).max()), 4)
    return found


def main() -> None:
    """Prints the figures of every spacing."""
    design = load_design("mini-magictac")
    zone = contact_zone([place_object(BALL, gap_mm=-DEPTH_MM)], design)
    if zone is None:
        return
    for override in ([], ["lattice.spacing_mm=0.5"]):
        block = load_design("mini-magictac", override)
        found = figures(block, build_lattice(block, zone=zone))
        sys.stdout.write(json.dumps({"overrides": override} | found) + "\n")
    for spacing in SPACINGS_MM:
        lattice = central_lattice(design, zone, spacing_mm=spacing, is_quarter=True)
        sys.stdout.write(json.dumps({"spacing_mm": spacing} | figures(design, lattice)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
