"""From which depth on the lateral force of an indenter beside a cell's middle stops rising, with infill that flows.

    python benchmarks/critical_shear.py --diameter-mm 2 --skin-mm 0.6 --yield-kpa 4.7   # one JSON line for each depth

The axis of a domed cylinder is 0.2 mm from the middle of a cell (0.173 along x, 0.1 along y), friction 1, as in
`docs/predictions/beside.csv`: walls are resolved below it on the whole block. The infill there carries all of its shear
in a network that flows (`magicsim.deform.lattice.yielding`, here without cells that are mixed of walls and infill), but
for a part that keeps it stable; that of the effective core around flows not. Walls neither buckle nor tear. Load steps
are 0.1 mm with a yield stress and 0.25 mm without one, and lateral forces depend on them: compare rows of equal steps
(`--yield-kpa 1000`, at which nothing flows, for one without flow).
"""

import argparse
import json
import sys

import numpy as np
from magicsim_experiments.study.mechanics.limit_press import GROWTH

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.core_failure import CoreLaw
from magicsim.deform.lattice.spot import resolved_lattice
from magicsim.deform.lattice.yielding import FlowLaw
from magicsim.deform.lattice.zone import Zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import load_design
from magicsim.geometry.grid import symmetric_place
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

OFFSET_MM, SPACING_MM, MARGIN_MM, STEP_MM = (0.173, 0.1), 0.45, 0.5, 0.25
"""Of the axis from the middle; lattice below the dome, and how far around it that is fine; between depths."""
KEPT = 0.02
"""Part of the infill's shear modulus that never flows."""


def main() -> None:
    """Prints the forces at every depth."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--diameter-mm", type=float, default=2)
    parser.add_argument("--skin-mm", type=float, default=0.6)
    parser.add_argument("--yield-kpa", type=float, help="no flow where it is left out")
    parser.add_argument("--deepest-mm", type=float, default=2.5)
    options = parser.parse_args()
    design = load_design("mini-magictac", [f"skin_mm={options.skin_mm}"])
    infill, (x, y) = design.materials.infill, symmetric_place(design, "cell")
    assert infill is not None
    dome = parse_object(f"domed_cylinder:radius_mm={options.diameter_mm / 2}")
    spot = Zone(low_mm=(x, y), high_mm=(x, y)).grown(options.diameter_mm / 2)
    lattice = resolved_lattice(design, spot, margin_mm=MARGIN_MM, spacing_mm=SPACING_MM, growth=GROWTH)
    law = None
    if options.yield_kpa is not None:
        cells = np.flatnonzero(np.isclose(lattice.shear_modulus_mpa, infill.shear_modulus_mpa))
        shear = options.yield_kpa / 1000 / infill.shear_modulus_mpa
        flow = FlowLaw(cells=cells, modulus_mpa=(1 - KEPT) * infill.shear_modulus_mpa, shear=shear)
        law = CoreLaw(flow=flow)
    solver = ContactSolver(lattice, friction=1.0, point_spacing_mm=point_spacing_mm(dome.shape()), core=law)
    state = None
    for depth in np.arange(STEP_MM, options.deepest_mm + STEP_MM / 2, STEP_MM):
        state = solver.solve(place_object(dome, gap_mm=-depth, x_mm=x + OFFSET_MM[0], y_mm=y + OFFSET_MM[1]), state)
        heat = state.core.dissipated_nmm if state.core is not None else 0.0
        row = {"depth_mm": float(depth), "force_n": state.force_n.round(5).tolist(), "dissipated_nmm": round(heat, 5)}
        sys.stdout.write(json.dumps(vars(options) | row) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
