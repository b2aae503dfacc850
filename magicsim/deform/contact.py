"""Rigid, frictionless contact of an object with the contact face, by an augmented Lagrangian.

Contact is tested on the points of `face`; the sides of the block are never in contact. With gap d (signed distance
to the object), multiplier m and penalty e the traction is t = max(0, m - e d) along the object's outward normal; a
multiplier update m <- t lowers the penetration without a stiffer matrix (Simo and Laursen 1992).
"""

from dataclasses import dataclass

import numba as nb
import numpy as np
import numpy.typing as npt

from magicsim.deform.face import ContactFace
from magicsim.deform.pattern import BlockPattern
from magicsim.geometry.indenter import Indenter

Array = npt.NDArray[np.float64]
CURVATURE_STEP_MM = 1e-4
"""Step of the finite differences of the object's normal."""
AXIS_LIMIT = 0.9
"""Normals nearer to the x axis than this take y as the helper for their tangents."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactState:
    """What the object does to the face at given positions and multipliers."""

    points_mm: Array
    """Positions of the quadrature points, shape (points, 3) [mm]."""
    gap_mm: Array
    """Signed distance to the object, shape (points,) [mm]."""
    normal: Array
    """The object's outward normal, shape (points, 3)."""
    traction_mpa: Array
    """Pressure per rest area, non-negative, shape (points,) [MPa]."""
    energy_mj: float
    """Augmented contact energy, up to a constant [N mm]."""
    node_force_n: Array
    """Force of the object on the nodes, shape (nodes, 3) [N]."""

    @property
    def max_penetration_mm(self) -> float:
        """Deepest point inside the object [mm]."""
        return max(0.0, -float(self.gap_mm.min()))


def evaluate_contact(
    face: ContactFace, nodes: Array, indenter: Indenter, multipliers: Array, penalty: float
) -> ContactState:
    """Gaps, tractions and nodal forces.

    Args:
        face: The quadrature points.
        nodes: Node positions, shape (nodes, 3) [mm].
        indenter: The object in its pose.
        multipliers: Augmented Lagrangian multipliers, shape (points,) [MPa].
        penalty: Stiffness [N/mm3].
    """
    points = face.positions(nodes)
    gap, normal = indenter.distance(points)
    traction = np.maximum(0.0, multipliers - penalty * gap)
    force = np.zeros_like(nodes)
    touching = np.flatnonzero(traction > 0)
    corner_force = (face.area_mm2 * traction)[touching, None, None] * face.shape[touching][:, :, None]
    np.add.at(force, face.patches[face.facet[touching]], corner_force * normal[touching][:, None, :])
    return ContactState(
        points_mm=points,
        gap_mm=gap,
        normal=normal,
        traction_mpa=traction,
        energy_mj=float(face.area_mm2 @ traction**2) / (2 * penalty),
        node_force_n=force,
    )


def add_contact_stiffness(
    values: Array,
    face: ContactFace,
    state: ContactState,
    indenter: Indenter,
    pattern: BlockPattern,
    *,
    penalty: float,
    curvature_limit: float,
) -> None:
    """Adds the contact's Hessian to the entries of an upper triangle, in place.

    Args:
        values: Entries in the pattern's order, changed.
        face: The quadrature points.
        state: From `evaluate_contact`.
        indenter: The object in its pose.
        pattern: Where the entries go.
        penalty: Stiffness [N/mm3].
        curvature_limit: Largest traction times curvature that is taken into account [N/mm3]; below, convergence is
            quadratic; sharp edges and tractions far from equilibrium would only make the matrix indefinite.
    """
    touching = np.flatnonzero(state.traction_mpa > 0)
    if len(touching) == 0:
        return
    normal, traction = state.normal[touching], state.traction_mpa[touching]
    curvature = _normal_gradient(indenter, state.points_mm[touching], normal)
    size = np.linalg.norm(curvature, axis=(1, 2))
    scale = np.minimum(traction, curvature_limit / np.maximum(size, 1e-12))
    local = penalty * normal[:, :, None] * normal[:, None, :] - scale[:, None, None] * curvature
    local *= face.area_mm2[touching][:, None, None]
    facet = face.facet[touching]
    _scatter(local, face.shape[touching], facet, face.patches, pattern.indptr, pattern.patch_blocks, values)


def _normal_gradient(indenter: Indenter, points: Array, normal: Array) -> Array:
    """Symmetric gradient of the normal across itself, shape (count, 3, 3) [1/mm], by forward differences."""
    helper = np.where(np.abs(normal[:, :1]) < AXIS_LIMIT, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1)[:, None]
    gradient = np.zeros((len(points), 3, 3))
    for tangent in (first, np.cross(normal, first)):
        moved = indenter.distance(points + CURVATURE_STEP_MM * tangent)[1]
        change = (moved - normal) / CURVATURE_STEP_MM
        gradient += change[:, :, None] * tangent[:, None, :]
    projector = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    gradient = projector @ gradient
    return np.asarray((gradient + gradient.transpose(0, 2, 1)) / 2)


@nb.njit(cache=True)
def _scatter(local, shape, facet, patches, indptr, blocks, values):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    for q in range(len(facet)):
        cell = facet[q]
        for a in range(patches.shape[1]):
            for b in range(a, patches.shape[1]):
                weight = shape[q, a] * shape[q, b]
                for i in range(3):
                    start = indptr[3 * patches[cell, a] + i] + 3 * blocks[cell, a, b] - i
                    for k in range(i if a == b else 0, 3):
                        values[start + k] += weight * local[q, i, k]
