"""Coulomb friction by return mapping on anchors.

A point is held by an anchor that moves with the object: the trial traction is -e_t times the tangential part s
of its distance from the anchor, and where that exceeds the limit r = mu p it is cut to r (slip) and the anchor is
dragged along. While an iteration runs, r is frozen at the pressure, and the tangent planes at the normals, it started
from (the symmetrised algorithm of Laursen and Simo 1993): the problem then has a potential, so its matrix stays
symmetric and a merit can be followed. The frozen limit acts whether the point touches or not; were it to come and go
with the contact, the potential would jump.
"""

from dataclasses import dataclass, replace

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.contact.face import ContactFace

TINY = 1e-300
AT_LIMIT = 1e-6
"""Part by which the trial traction of a sliding point exceeds its limit: one that a load step has left there is exactly
at it, sticks until it is moved on, and rounding must not decide that."""
LIMIT_SHARE = (0.1, 2.0)
"""Smallest and largest relaxation of the limits: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactLaw:
    """Numbers of the contact that do not change along a path."""

    slip_penalty: float
    """Largest stiffness of a sticking point against tangential motion [N/mm3]."""
    elastic_slip_mm: float = 0.0
    """Motion of a sticking point on the way to its limit is at least this; lightly pressed points would be all or
    nothing otherwise."""
    friction: float
    """Coulomb's coefficient; 0 is frictionless."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactMemory:
    """Memory of contact beside the present positions."""

    multipliers_mpa: Array
    """Augmented Lagrangian multipliers, shape (points,) [MPa]."""
    penalty: float
    """Stiffness along the normal [N/mm3]."""
    updates: int = 0
    """Updates of the multipliers in this load step."""
    anchors_mm: Array
    """Where friction holds each point, in the sensor's frame, shape (points, 3) [mm]."""
    limit_mpa: Array
    """Frozen limit of the tangential traction, shape (points,) [MPa]."""
    normal: Array
    """Frozen normals of the tangent planes, shape (points, 3)."""
    limit_excess_mpa: Array | None = None
    """Lack of the limits when they were last updated, shape (points,) [MPa]."""
    limit_share: float = 1.0
    """Part of it by which they were changed."""


def friction_traction(face: ContactFace, points: Array, memory: ContactMemory, law: ContactLaw) -> tuple[Array, float]:
    """Traction of points at positions of shape (points, 3) [mm], of that shape [MPa], and the energy behind it [mJ]."""
    traction = np.zeros_like(points)
    held = np.flatnonzero(memory.limit_mpa > 0)
    if len(held) == 0:
        return traction, 0.0
    slip, size = _slip(points[held], memory, held)
    stiffness, area = stick_stiffness(memory, law)[held], face.area_mm2[held]
    amount = np.minimum(stiffness * size, memory.limit_mpa[held])
    traction[held] = -(amount / np.maximum(size, TINY))[:, None] * slip
    return traction, float(area @ (amount * size - amount**2 / (2 * stiffness)))


def updated_limits(
    memory: ContactMemory, pressure_mpa: Array, normal: Array, law: ContactLaw, *, is_relaxed: bool
) -> ContactMemory:
    """Friction limits moved to mu times the pressure, tangent planes to the present normals.

    With `is_relaxed` they go only part of the way, by Aitken's relaxation: limits that chase the pressures settle in
    fewer updates then (Irons and Tuck 1969). Pressures and normals are those at every point.
    """
    excess = law.friction * pressure_mpa - memory.limit_mpa
    share, before = 1.0, memory.limit_excess_mpa
    if is_relaxed and before is not None:
        change = excess - before
        size = float(change @ change)
        aitken = -memory.limit_share * float(before @ change) / size if size > 0 else 1.0
        share = float(np.clip(aitken, *LIMIT_SHARE))
    limit = np.maximum(memory.limit_mpa + share * excess, 0.0)
    return replace(memory, limit_mpa=limit, normal=normal, limit_excess_mpa=excess, limit_share=share)


def stick_stiffness(memory: ContactMemory, law: ContactLaw) -> Array:
    """Stick stiffness of each point, shape (points,) [N/mm3]."""
    if law.elastic_slip_mm == 0:
        return np.full(len(memory.limit_mpa), law.slip_penalty)
    return np.minimum(law.slip_penalty, memory.limit_mpa / law.elastic_slip_mm)


def _slip(points: Array, memory: ContactMemory, held: Index) -> tuple[Array, Array]:
    """Tangential offset from the anchors, shape (count, 3) [mm], and its length, shape (count,) [mm]."""
    offset, normal = points - memory.anchors_mm[held], memory.normal[held]
    slip = offset - np.einsum("qi,qi->q", offset, normal)[:, None] * normal
    return slip, np.linalg.norm(slip, axis=1)


def friction_stiffness(points: Array, memory: ContactMemory, law: ContactLaw, held: Index, *, is_secant: bool) -> Array:
    """Derivative of the traction of points `held` by their motion, its sign changed, shape (count, 3, 3) [N/mm3].

    With `is_secant` sliding points get their secant instead, which is never too soft.
    """
    slip, size = _slip(points, memory, held)
    limit, normal = memory.limit_mpa[held], memory.normal[held]
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    stick = stick_stiffness(memory, law)[held]
    slides = stick * size > (1 + AT_LIMIT) * limit
    if is_secant:
        return np.asarray(np.where(slides, limit / np.maximum(size, TINY), stick)[:, None, None] * tangent)
    along = np.where(slides, 1 / np.maximum(size, TINY), 0.0)[:, None] * slip
    tangent -= along[:, :, None] * along[:, None, :]
    stiffness = np.where(slides, limit / np.maximum(size, TINY), stick)
    return np.asarray(stiffness[:, None, None] * tangent)
