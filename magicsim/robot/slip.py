"""How much of a contact slides and how far, from Coulomb's law as the solver holds it: no threshold on images."""

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.deformation import Deformation


def slip_share(deformation: Deformation, area_mm2: Array) -> float:
    """Share of the normal force that presses on sliding points, 0 without contact, 1 in full slip.

    Args:
        deformation: An equilibrium.
        area_mm2: Rest area of each contact point, shape (points,) [mm2].
    """
    if deformation.is_rest:
        return 0.0
    force = area_mm2 * deformation.contact_pressure_mpa
    total = float(force.sum())
    return float(force[deformation.is_slipping].sum()) / total if total > 0 else 0.0


def slip_mm(before: Deformation, after: Deformation, area_mm2: Array) -> float:
    """How far the skin slid over the object between two equilibria, the mean over the contact [mm].

    A sticking point keeps its anchor in the object's frame and a sliding one drags it along (see
    `magicsim.deform.contact.friction`), so the anchors' way is the way of sliding. Points count by their normal force
    after.

    Args:
        before: The equilibrium before, of the same lattice.
        after: The one that followed from it.
        area_mm2: Rest area of each contact point, shape (points,) [mm2].
    """
    if before.is_rest or after.is_rest:
        return 0.0
    touching = (before.contact_pressure_mpa > 0) & (after.contact_pressure_mpa > 0)
    weight = (area_mm2 * after.contact_pressure_mpa)[touching]
    way = np.linalg.norm((after.anchors_mm - before.anchors_mm)[touching], axis=1)
    total = float(weight.sum())
    return float(weight @ way) / total if total > 0 else 0.0
