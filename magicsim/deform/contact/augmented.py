"""Rigid contact of an object with the contact face: an augmented Lagrangian, and Coulomb friction by return mapping.

Contact is tested on the points of `face`; the sides of the block are never in contact. With gap d (signed distance
to the object), multiplier m and penalty e the pressure is p = max(0, m - e d) along the object's outward normal; a
multiplier update m <- p lowers the penetration without a stiffer matrix (Simo and Laursen 1992).
Friction is in `friction`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.contact.face import ContactFace, scatter
from magicsim.deform.contact.friction import (
    TINY,
    ContactLaw,
    ContactMemory,
    friction_stiffness,
    friction_traction,
    stick_stiffness,
    updated_limits,
)
from magicsim.deform.lattice.pattern import BlockPattern
from magicsim.deform.quality import NewtonOptions
from magicsim.geometry.indenter import Indenter
from magicsim.kernels import kernel

Surface = Callable[[Array], tuple[Array, Array]]
"""Signed distance, shape (count,) [mm], and outward normal, shape (count, 3), at points of shape (count, 3) [mm]."""
CURVATURE_STEP_MM = 1e-4
"""Step of the finite differences of the object's normal."""
AXIS_LIMIT = 0.9
"""Normals nearer to the x axis than this take y as the helper for their tangents."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactState:
    """Gaps, tractions and forces of an object on the face at given positions and memory."""

    points_mm: Array
    """Positions of the quadrature points, shape (points, 3) [mm]."""
    gap_mm: Array
    """Signed distance to the object, shape (points,) [mm]."""
    normal: Array
    """The object's outward normal, shape (points, 3)."""
    pressure_mpa: Array
    """Pressure per rest area, non-negative, shape (points,) [MPa]."""
    shear_mpa: Array
    """Tangential traction per rest area, shape (points, 3) [MPa]."""
    energy_mj: float
    """Augmented contact energy with the frozen friction limit, up to a constant [N mm]."""
    node_force_n: Array
    """Force of the object on the nodes, shape (nodes, 3) [N]."""
    acting: Index
    """Points that touch, or that friction still holds, shape (count,)."""

    @property
    def max_penetration_mm(self) -> float:
        """Deepest point inside the object [mm]."""
        return max(0.0, -float(self.gap_mm.min()))

    @property
    def misfit_mm(self) -> float:
        """Deepest point inside the object, or widest gap under pressure (a multiplier that is out of date) [mm]."""
        return max(self.max_penetration_mm, float(self.gap_mm[self.pressure_mpa > 0].max(initial=0.0)))

    def traction_mpa(self) -> Array:
        """Traction of the object on the face per rest area, shape (points, 3) [MPa]."""
        return np.asarray(self.pressure_mpa[:, None] * self.normal + self.shear_mpa)


def evaluate_contact(
    face: ContactFace, nodes: Array, surface: Surface, memory: ContactMemory, law: ContactLaw
) -> ContactState:
    """Gaps, tractions and nodal forces where the nodes stand at positions of shape (nodes, 3) [mm]."""
    points = face.positions(nodes)
    gap, normal = surface(points)
    return _pressed(face, points, gap, normal, memory, law, np.zeros_like(nodes))


def remembered(face: ContactFace, state: ContactState, memory: ContactMemory, law: ContactLaw) -> ContactState:
    """A state with another memory: nothing has moved."""
    return _pressed(face, state.points_mm, state.gap_mm, state.normal, memory, law, np.zeros_like(state.node_force_n))


def _pressed(
    face: ContactFace, points: Array, gap: Array, normal: Array, memory: ContactMemory, law: ContactLaw, force: Array
) -> ContactState:
    """Tractions of points; their forces are added to those of the nodes, shape (nodes, 3) [N]."""
    pressure = np.maximum(0.0, memory.multipliers_mpa - memory.penalty * gap)
    shear, slip_energy = friction_traction(face, points, memory, law)
    acting = np.flatnonzero((pressure > 0) | (memory.limit_mpa > 0))
    vectors = face.area_mm2[acting, None] * (pressure[acting, None] * normal[acting] + shear[acting])
    scatter(face.shape, face.facet, face.patches, acting, vectors, force)
    return ContactState(
        points_mm=points,
        gap_mm=gap,
        normal=normal,
        pressure_mpa=pressure,
        shear_mpa=shear,
        energy_mj=float(face.area_mm2 @ pressure**2) / (2 * memory.penalty) + slip_energy,
        node_force_n=force,
        acting=acting,
    )


def contact_stiffness(
    state: ContactState,
    face: ContactFace,
    surface: Surface,
    memory: ContactMemory,
    law: ContactLaw,
    *,
    curvature_limit: float,
    is_secant: bool = False,
) -> Array:
    """The contact's Hessian at each acting point, friction limits frozen, shape (acting, 3, 3) [N/mm].

    Pressure times curvature counts up to a limit [N/mm3]: with all of it convergence is quadratic, but that of sharp
    edges, and of tractions far from equilibrium, would only make the matrix indefinite. With `is_secant` slipping
    points get the secant stiffness of their friction, which is never too soft: where the tangent led to a step that
    had to be shortened.
    """
    acting = state.acting
    normal, pressure = state.normal[acting], state.pressure_mpa[acting]
    curvature = _normal_gradient(surface, state.points_mm[acting], normal)
    size = np.linalg.norm(curvature, axis=(1, 2))
    scale = np.minimum(pressure, curvature_limit / np.maximum(size, 1e-12))
    penalty = np.where(pressure > 0, memory.penalty, 0.0)
    local = penalty[:, None, None] * normal[:, :, None] * normal[:, None, :] - scale[:, None, None] * curvature
    if law.friction > 0:
        local += friction_stiffness(state.points_mm[acting], memory, law, acting, is_secant=is_secant)
    return np.asarray(local * face.area_mm2[acting][:, None, None])


def add_sparse_stiffness(values: Array, face: ContactFace, acting: Index, local: Array, pattern: BlockPattern) -> None:
    """Adds the Hessian of points, shape (acting, 3, 3), to the entries of an upper triangle, in place."""
    facet = face.facet[acting]
    _scatter_blocks(local, face.shape[acting], facet, face.patches, pattern.indptr, pattern.patch_blocks, values)


def add_dense_stiffness(matrix: Array, face: ContactFace, acting: Index, local: Array) -> None:
    """Adds the Hessian of points, shape (acting, 3, 3), to a matrix of shape (3 nodes, 3 nodes), in place."""
    _scatter_dense(local, face.shape[acting], face.facet[acting], face.patches, matrix)


def slip_mismatch(face: ContactFace, state: ContactState, memory: ContactMemory, law: ContactLaw) -> float:
    """Forces by which friction is off its law, over the largest force of friction; infinite of a force on a free face.

    Both count: limits that are not mu times the pressure, and tractions out of the tangent planes.
    """
    total = law.friction * float(face.area_mm2 @ state.pressure_mpa)
    if total == 0:
        return math.inf if memory.limit_mpa.any() else 0.0
    excess = np.abs(memory.limit_mpa - law.friction * state.pressure_mpa)
    outward = np.abs(np.einsum("qi,qi->q", state.shear_mpa, state.normal))
    return float(face.area_mm2 @ (excess + outward)) / total


def dragged_anchors(state: ContactState, memory: ContactMemory, law: ContactLaw) -> Array:
    """Anchors after a converged step: a slipping point drags its own, a free point has it at itself, (points, 3)."""
    stiffness = np.maximum(stick_stiffness(memory, law), TINY)
    return np.asarray(state.points_mm + state.shear_mpa / stiffness[:, None])


def moved_surface(indenter: Indenter, before: Indenter) -> Surface:
    """The object's surface as it stood before a motion, carried along by it to first order.

    Points keep the side on which they were: a motion longer than a tip is wide would otherwise leave them nearest to
    the far side. It predicts where the contact goes; the equilibrium itself is found on the true surface.
    """

    def surface(points: Array) -> tuple[Array, Array]:
        gap, normal = before.distance(points)
        motion = indenter.pose.to_sensor(before.pose.to_object(points)) - points
        return gap - np.einsum("qi,qi->q", normal, motion), normal

    return surface


def _normal_gradient(surface: Surface, points: Array, normal: Array) -> Array:
    """Symmetric gradient of the normal across itself, shape (count, 3, 3) [1/mm].

    Differences are central: forward ones would know the sense of the tangents, and a mirror image has the other one.
    """
    helper = np.where(np.abs(normal[:, :1]) < AXIS_LIMIT, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1)[:, None]
    tangents = np.stack([first, np.cross(normal, first)])
    steps = CURVATURE_STEP_MM * np.stack([tangents, -tangents], 1)
    ahead, behind = surface((points + steps).reshape(-1, 3))[1].reshape(2, 2, -1, 3).swapaxes(0, 1)
    change = (ahead - behind) / (2 * CURVATURE_STEP_MM)
    gradient = (change[..., None] * tangents[..., None, :]).sum(0)
    projector = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    gradient = projector @ gradient
    return np.asarray((gradient + gradient.transpose(0, 2, 1)) / 2)


@kernel()
def _scatter_blocks(local, shape, facet, patches, indptr, blocks, values):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Adds the Hessian of points to an upper triangle: by nodes a and b it is N_a N_b times that by the point."""
    for q in range(len(facet)):
        cell = facet[q]
        for a in range(patches.shape[1]):
            for b in range(a, patches.shape[1]):
                weight = shape[q, a] * shape[q, b]
                for i in range(3):
                    # row i of a diagonal block has lost its first i entries, see `block_pattern`
                    start = indptr[3 * patches[cell, a] + i] + 3 * blocks[cell, a, b] - i
                    for k in range(i if a == b else 0, 3):
                        values[start + k] += weight * local[q, i, k]


@kernel()
def _scatter_dense(local, shape, facet, patches, matrix):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Adds the same to a dense matrix, both triangles."""
    for q in range(len(facet)):
        cell = facet[q]
        for a in range(patches.shape[1]):
            for b in range(patches.shape[1]):
                weight = shape[q, a] * shape[q, b]
                for i in range(3):
                    for k in range(3):
                        matrix[3 * patches[cell, a] + i, 3 * patches[cell, b] + k] += weight * local[q, i, k]


def updated_memory(
    options: NewtonOptions, law: ContactLaw, memory: ContactMemory, contact: ContactState, residual: float,
    mismatch: float, *, is_late: bool,
) -> ContactMemory:  # fmt: skip
    """The memory with the updates that are due; the same object where none is.

    Late in a load step limits of friction are updated in balance only, and go only part of the way.
    """
    if mismatch > options.slip_mismatch and residual < options.limit_residual[is_late]:
        memory = updated_limits(memory, contact.pressure_mpa, contact.normal, law, is_relaxed=is_late)
    if residual >= options.update_residual or contact.misfit_mm <= options.tolerance_mm:
        return memory
    if memory.updates < options.multiplier_updates:
        return replace(memory, multipliers_mpa=contact.pressure_mpa, updates=memory.updates + 1)
    if contact.misfit_mm <= options.harmless_misfit_mm:
        return memory
    updates = options.multiplier_updates - options.reprieve
    return replace(memory, penalty=options.penalty_growth * memory.penalty, updates=updates)
