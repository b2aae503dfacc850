"""What a core that fails does to a deep press: domes on skins of 0.3 and 0.6 mm, walls whole, buckled, torn and gone.

    python benchmarks/failed_core.py                  # one JSON line for each skin and core
    python benchmarks/failed_core.py --spacing-mm 0.35 --step-mm 0.05

A dome of 2 mm diameter is pressed with friction 1 into a quarter of `mini-magictac`, down to 3.2 mm. Cores: `elastic`,
as the lattice has it; `buckled`, whose walls carry no more from a squeeze of 8 % on, that of a long plate between soft
halves, (6 r)^(2/3) / 4 with r the ratio of the infill's to the walls' modulus (Allen 1969); those whose walls tear at
an elongation, 220 % as Agilus30's data sheet is quoted, and less, as thin printed walls may; `gone`, infill alone, as
if all were torn. Beside the force stand torn cells of the quarter, heat, the largest stretch of a printed
cell's walls and of the skin, at each depth until no equilibrium is found.
"""

import argparse
import json
import sys
from dataclasses import replace

import numpy as np

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.core_failure import CoreLaw, weakened
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.spot import QUARTERS, central_lattice
from magicsim.deform.lattice.tearing import TearLaw
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import SkinCells
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign, load_design
from magicsim.geometry.indenter import place_object
from magicsim.geometry.limits import CoreFailure
from magicsim.geometry.objects.kinds import parse_object

DOME, DEPTHS_MM, SKINS_MM = parse_object("domed_cylinder:radius_mm=1"), (0.8, 1.6, 2.4, 2.8, 3.2), (0.3, 0.6)


def cores(design: ElastomerDesign) -> dict[str, CoreFailure | None]:
    """How walls fail, by name; None has none."""
    body, infill = design.materials.body, design.materials.infill
    assert infill is not None
    wrinkles = float((6 * infill.shear_modulus_mpa / body.shear_modulus_mpa) ** (2 / 3) / 4)
    return {
        "elastic": CoreFailure(),
        "buckled": CoreFailure(wall_buckling_strain=wrinkles),
        **{f"tears_{100 * each:g}": CoreFailure(wall_tear_elongation=each) for each in (2.2, 0.8, 0.4)},
        "gone": None,
    }


def pressed(
    design: ElastomerDesign, failure: CoreFailure | None, spacing_mm: float, step_mm: float
) -> list[dict[str, object]]:
    """Figures of one core at every depth."""
    poses = [place_object(DOME, gap_mm=-depth) for depth in np.arange(step_mm, DEPTHS_MM[-1] + step_mm / 2, step_mm)]
    zone = contact_zone(poses, design)
    assert zone is not None
    lattice = central_lattice(design, zone, spacing_mm=spacing_mm, is_quarter=True)
    walls = TearLaw.of(design, lattice, 1.0)
    assert walls is not None
    if failure is None:
        modulus = np.where(lattice.is_core, walls.modulus_mpa, lattice.shear_modulus_mpa)
        lattice = replace(lattice, shear_modulus_mpa=modulus, wall_modulus_mpa=np.zeros(len(lattice.cells)))
    else:
        lattice = weakened(lattice, failure)
    solver = ContactSolver(
        lattice, friction=1.0, point_spacing_mm=point_spacing_mm(DOME.shape()),
        core=CoreLaw.of(design, lattice, failure or CoreFailure()),
    )  # fmt: skip
    whole, skin, state, rows = Elasticity.of(lattice), SkinCells.of(design, lattice), None, list[dict[str, object]]()
    for pose in poses:
        try:
            state = solver.solve(pose, state)
        except ConvergenceError as error:
            return [*rows, {"depth_mm": round(pose.top_mm(), 3), "stopped": str(error)}]
        row = {
            "depth_mm": round(pose.top_mm(), 3),
            "force_n": round(QUARTERS * float(state.force_n[2]), 3),
            "torn": int(state.core.torn.sum()) if state.core is not None else 0,
            "dissipated_nmm": round(QUARTERS * state.core.dissipated_nmm, 4) if state.core is not None else 0.0,
            "wall_stretch": round(float(walls.stretches(whole, lattice.nodes_mm + state.displacements_mm).max()), 3),
            "skin_stretch": round(skin.strained(state)[0], 3),
        }
        if any(np.isclose(pose.top_mm(), DEPTHS_MM)):
            rows.append(row)
    return rows


def main() -> None:
    """Prints the figures of every skin and core."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--spacing-mm", type=float, default=0.5)
    parser.add_argument("--step-mm", type=float, default=0.1)
    options = parser.parse_args()
    for skin in SKINS_MM:
        design = load_design("mini-magictac", [f"skin_mm={skin}", "footprint_mm=[14,14]"])
        for name, failure in cores(design).items():
            for row in pressed(design, failure, options.spacing_mm, options.step_mm):
                sys.stdout.write(json.dumps({"skin_mm": skin, "core": name} | row) + "\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
