"""Hardness with other laws of body and infill, by secant moduli: what a mechanism can do, not a model of it.

The reading is found with the usual law; each cell then gets the shear modulus that another law would have at the
strain that it has there, and the reading is found again, some rounds long. For a hyperelastic law whose stress is that
of a neo-Hookean solid times a function of the first invariant (Gent) that is the law itself, up to the mean over a
cell.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np
import numpy.typing as npt

from magicsim.deform.indentation import durometer as module
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS
from magicsim.deform.lattice.structure import Lattice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import Place

Array = npt.NDArray[np.float64]
GENT_LIMIT = 15.0
"""J_m of Gent's law: Agilus30 breaks at an elongation of 220 to 270 % (data sheet), I1 - 3 of 8 to 11, so J_m is more
than that; a smaller one stiffens sooner."""
MOST = 20.0
"""Largest factor of a modulus."""
Law = Callable[[Array, Array, Array], Array]
"""Factor of each cell's modulus from I1 - 3 at constant volume, the modulus [MPa], and whether it is infill."""


def usual(excess: Array, modulus: Array, is_infill: Array) -> Array:
    """The neo-Hookean solid."""
    del modulus, is_infill
    return np.ones_like(excess)


def gent(excess: Array, modulus: Array, is_infill: Array) -> Array:
    """The body stiffens towards its limit (Gent 1996)."""
    del modulus
    factor = GENT_LIMIT / np.maximum(GENT_LIMIT - excess, GENT_LIMIT / MOST)
    return np.where(is_infill, 1.0, factor)


def without_walls(excess: Array, modulus: Array, is_infill: Array) -> Array:
    """Walls below the cone carry no more than infill, whatever their strain: more than buckling or tearing could do."""
    return usual(excess, modulus, is_infill)


def reading(
    design: ElastomerDesign, law: Law, place: Place, *, spacing_mm: float, step_mm: float, rounds: int
) -> dict[str, Any]:
    """Shore A after each round, and the largest strain and stress of the infill in the last one.

    Args:
        design: The sample, its mounting included.
        law: Of the cells whose walls are resolved.
        place: Of the cone.
        spacing_mm: Of the nodes below it [mm].
        step_mm: Motion of the cone in one load step [mm].
        rounds: How often moduli are brought up to date; `without_walls` takes one.
    """
    plain, infill = module.quarter_lattice, design.materials.infill
    assert infill is not None
    kept: dict[str, Any] = {"factor": 1.0}

    def changed(*arguments: Any) -> Lattice:  # noqa: ANN401
        lattice = plain(*arguments)
        is_infill = np.isclose(lattice.shear_modulus_mpa, infill.shear_modulus_mpa)
        factor = np.broadcast_to(kept["factor"], is_infill.shape)
        if law is without_walls:
            is_wall = lattice.is_core & ~is_infill & (lattice.wall_modulus_mpa == 0)
            factor = np.where(is_wall, infill.shear_modulus_mpa / lattice.shear_modulus_mpa, 1.0)
        kept.update(lattice=lattice, is_infill=is_infill)
        return replace(lattice, shear_modulus_mpa=lattice.shear_modulus_mpa * factor)

    shores, told = [], lambda *_: None
    with patch.object(module, "quarter_lattice", changed):
        for _ in range(1 if law in (usual, without_walls) else 1 + rounds):
            test = module.DurometerTest(design, "resolved", spacing_mm=spacing_mm, place=place)
            depth, state = test.equilibrium(step_mm, module.FORCE_TOLERANCE_N, told)
            shores.append(100 * (1 - depth / module.EXTENSION_MM))
            lattice, is_infill = kept["lattice"], kept["is_infill"]
            excess = _excess(lattice, state.displacements_mm)
            if law is not without_walls:
                kept["factor"] = law(excess, lattice.shear_modulus_mpa, is_infill)
    resolved = lattice.wall_modulus_mpa == 0
    body = excess[~is_infill & resolved]
    gel = np.sqrt(np.maximum(excess[is_infill], 0))
    return {
        "shore_a": shores,
        "infill_shear_strain": np.quantile(gel, [0.5, 0.9, 1.0]).round(2).tolist(),
        "body_i1_excess": np.quantile(body, [0.9, 0.99, 1.0]).round(2).tolist(),
        "min_jacobian": state.min_jacobian,
    }


def _excess(lattice: Lattice, displacements_mm: Array) -> Array:
    """Mean of I1 J^(-2/3) - 3 over the Gauss points of each cell, shape (cells,)."""
    elasticity = Elasticity.of(lattice)
    corners = (lattice.nodes_mm + displacements_mm)[lattice.cells].transpose(0, 2, 1)
    f = corners[:, None] @ GAUSS_GRADIENTS @ elasticity.inverse
    volume = np.maximum(np.linalg.det(f), 1e-6)
    return np.asarray(((f**2).sum((2, 3)) * volume ** (-2 / 3) - 3).mean(1))
