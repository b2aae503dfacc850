"""What a core that fails would do to a deep press: domes on skins of 0.3 and 0.6 mm, walls whole, buckled and gone.

    python benchmarks/failed_core.py                  # half a minute; one JSON line for each skin and core
    python benchmarks/failed_core.py --spacing-mm 0.35

A dome of 2 mm diameter is pressed 2.8 mm, with friction 1, into a quarter of `mini-magictac`. Cores: `elastic`, as the
lattice has it; `buckled`, whose walls carry no more along them than at a squeeze of 8 %, that of a long plate between
soft halves, (6 r)^(2/3) / 4 with r the ratio of the infill's to the walls' modulus (Allen 1969); `no_wall_load`, whose
walls carry nothing along them beyond the isotropic part; `no_walls`, infill alone, as if all were torn. Beside the
force stand the largest stretch along walls and the largest of the skin: a wall tears where the first reaches 1 plus
`limits.elongation_at_break`.
"""

import argparse
import json
import sys
from dataclasses import replace

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.cell_problem import cell_fields
from magicsim.deform.lattice.hexahedron import EDGES
from magicsim.deform.lattice.spot import QUARTERS, central_lattice
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.deform.strain import SkinCells
from magicsim.geometry.design import ElastomerDesign, load_design
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

DOME, DEPTHS_MM, SKINS_MM = parse_object("domed_cylinder:radius_mm=1"), (0.7, 1.4, 2.1, 2.8), (0.3, 0.6)
CORES = ("elastic", "buckled", "no_wall_load", "no_walls")
ABSENT = 1e-3
"""Shear modulus of walls that are gone, in units of their own."""
FOLLOWED = 0.7
"""See `cell_kernels`: the law of a wall is bounded from I = 1 / (1 + 2 FOLLOWED rho) on."""


def buckling_strain(design: ElastomerDesign) -> float:
    """Squeeze at which a long plate between soft halves wrinkles."""
    body, infill = design.materials.body, design.materials.infill
    assert infill is not None
    return float((6 * infill.shear_modulus_mpa / body.shear_modulus_mpa) ** (2 / 3) / 4)


def core_of(lattice: Lattice, design: ElastomerDesign, core: str) -> Lattice:
    """The lattice with another core."""
    if core in {"elastic", "buckled"}:
        return lattice
    lattice = replace(lattice, wall_modulus_mpa=np.zeros(len(lattice.cells)))
    if core == "no_wall_load":
        return lattice
    body, infill, grid = design.materials.body, design.materials.infill, lattice.grid
    assert infill is not None
    assert grid is not None
    alone = cell_fields(
        body=(ABSENT * body.shear_modulus_mpa, body.bulk_modulus_mpa),
        infill=(infill.shear_modulus_mpa, infill.bulk_modulus_mpa),
        infill_share=float(np.prod(grid.cell_mm / grid.pitch_mm)),
    ).stiffness
    isotropic = alone.shear_modulus_mpa + 2 / 5 * alone.wall_modulus_mpa
    modulus = np.where(lattice.is_core, isotropic, lattice.shear_modulus_mpa)
    return replace(lattice, shear_modulus_mpa=modulus)


def pressed(design: ElastomerDesign, core: str, spacing_mm: float) -> dict[str, object]:
    """Forces and stretches of one core."""
    poses = [place_object(DOME, gap_mm=-depth) for depth in DEPTHS_MM]
    zone = contact_zone(poses, design)
    assert zone is not None
    lattice = core_of(central_lattice(design, zone, spacing_mm=spacing_mm, is_quarter=True), design, core)
    solver = ContactSolver(lattice, friction=1.0, point_spacing_mm=point_spacing_mm(DOME.shape()))
    if core == "buckled":
        elasticity = solver._problem.elasticity
        rho = ((1 - buckling_strain(design)) ** -2 - 1) / (2 * FOLLOWED)
        bounded = replace(elasticity, wall_ratio=np.minimum(elasticity.wall_ratio, rho))
        solver._problem = replace(solver._problem, elasticity=bounded)
    state, forces = None, []
    for pose in poses:
        state = solver.solve(pose, state)
        forces.append(round(QUARTERS * float(state.force_n[2]), 3))
    assert state is not None

    def edges(places: Array) -> Array:
        corners = places[lattice.cells[lattice.is_core]]
        return np.asarray(np.linalg.norm(corners[:, EDGES[:, 1]] - corners[:, EDGES[:, 0]], axis=2))

    stretch = edges(lattice.nodes_mm + state.displacements_mm) / edges(lattice.nodes_mm)
    return {
        "force_n": forces,
        "wall_stretch": round(float(stretch.max()), 3),
        "skin_stretch": round(SkinCells.of(design, lattice).strained(state)[0], 3),
    }


def main() -> None:
    """Prints the figures of every skin and core."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--spacing-mm", type=float, default=0.5)
    spacing = parser.parse_args().spacing_mm
    for skin in SKINS_MM:
        design = load_design("mini-magictac", [f"skin_mm={skin}", "footprint_mm=[14,14]"])
        for core in CORES:
            found = {"skin_mm": skin, "core": core} | pressed(design, core, spacing)
            sys.stdout.write(json.dumps(found) + "\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
