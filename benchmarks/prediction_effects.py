"""What the block's walls and its mounting change of a press, and how far the skin is stretched.

    python benchmarks/prediction_effects.py     # some minutes; writes the part `effects` of docs/predictions.json

Quarters of the block with a homogenised core, much quicker than those of `predictions.py` with walls of their own:
their relative changes count. Walls of 0.2 mm come with the moduli that read nearest to the
two fitted samples, 33 and 21 Shore A instead of 33.25 and 17.1: no infill is soft enough for both.
"""

import json
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from hardness import Setting, sample
from predictions import CORE_MM, DOMES_MM, NOMINAL, RESULT, SKINS_MM

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.central import central_lattice
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

Array = npt.NDArray[np.float64]
SPACING_MM = 0.4
VARIANTS = {
    "nominal": NOMINAL,
    "on a table": replace(NOMINAL, base="table"),
    "walls 0.2 mm": replace(NOMINAL, wall_mm=0.2, body_mpa=1.4, infill_mpa=0.002),
}
DEPTHS = tuple(np.arange(0.5, 4.6, 0.5).tolist())
"""[mm]."""


def path(diameter_mm: float, skin_mm: float, setting: Setting) -> list[dict[str, Any]]:
    """Force at each depth, and the largest stretch and stress of the skin; refusals end it."""
    dome = parse_object(f"domed_cylinder:radius_mm={diameter_mm / 2}")
    block = sample(CORE_MM + 2 * skin_mm, skin_mm, setting).mounted(setting.mounting)
    zone = contact_zone([place_object(dome, gap_mm=-max(DEPTHS))], block)
    assert zone is not None
    lattice = central_lattice(block, zone, spacing_mm=SPACING_MM, is_quarter=True)
    solver = ContactSolver(lattice, friction=setting.friction, point_spacing_mm=point_spacing_mm(dome.shape()))
    state, rows = None, []
    for depth in DEPTHS:
        try:
            state = solver.solve(place_object(dome, gap_mm=-depth), state)
        except MagicsimError as error:
            return [*rows, {"depth_mm": depth, "refused": str(error)}]
        row = {"depth_mm": depth, "force_n": 4 * float(state.force_n[2])}
        rows.append(row | strains(lattice, state.displacements_mm, block))
    return rows


def strains(lattice: Lattice, displacements_mm: Array, block: ElastomerDesign) -> dict[str, float]:
    """Of the skin's cells, at their middles, and of the uppermost printed cell below the axis.

    Returns:
        Largest stretch and difference of principal stresses in the skin; least shear strain sqrt(I1 J^(-2/3) - 3) over
        the height of the printed cell, taken as that of the infill.
    """
    elasticity, middle = Elasticity.of(lattice), lattice.nodes_mm[lattice.cells].mean(1)
    corners = (lattice.nodes_mm + displacements_mm)[lattice.cells].transpose(0, 2, 1)
    f = (corners[:, None] @ GAUSS_GRADIENTS @ elasticity.inverse).mean(1)
    stretch = np.linalg.svd(f, compute_uv=False)
    volume = stretch.prod(1)
    stress = lattice.shear_modulus_mpa * (stretch[:, 0] ** 2 - stretch[:, 2] ** 2) / volume
    shear = np.sqrt(np.maximum((stretch**2).sum(1) * volume ** (-2 / 3) - 3, 0))
    below = (middle[:, :2] < SPACING_MM).all(1) & lattice.is_core
    below &= middle[:, 2] < block.skin_mm + block.cell_mm
    is_skin = middle[:, 2] < block.skin_mm
    return {
        "skin_stretch": float(stretch[is_skin, 0].max()),
        "skin_stress_mpa": float(stress[is_skin].max()),
        "cell_shear": float(shear[below].min()),
    }


def main() -> None:
    """Computes all of them and keeps them beside the predictions."""
    for diameter in DOMES_MM:
        for thickness in SKINS_MM:
            for name, setting in VARIANTS.items():
                results = json.loads(RESULT.read_text())
                key = f"{diameter:g} mm, skin {thickness:g}, {name}"
                if key in results.setdefault("effects", {}):
                    continue
                rows = path(diameter, thickness, setting)
                results = json.loads(RESULT.read_text())
                results.setdefault("effects", {})[key] = rows
                RESULT.write_text(json.dumps(results, indent=1) + "\n")
                sys.stderr.write(f"{key}: {rows[-1]}\n")


if __name__ == "__main__":
    main()
