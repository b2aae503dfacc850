"""What lies between two hits: read from the geometry of the next hit, so that no bookkeeping can go wrong.

A segment that ends on an infill cell from inside ran through that cell; one that ends on it from outside, or on
the body from inside, ran through the body. Only where the next hit is opaque, or there is none, does the caller's
memory decide. Rays displaced across an edge by the intersection offset therefore cannot carry a wrong state.
"""

from dataclasses import dataclass
from typing import Any

from magicsim.scenes.backend import dr, mi

CLEAR_PER_MM = 1e-12
"""Extinction that stands for none [1/mm]."""


@dataclass(slots=True, kw_only=True)
class Media:
    """Optical constants of the nested media, as plain numbers."""

    body_ior: float
    infill_ior: float
    body_absorption: float
    """Absorption of the body [1/mm]."""
    sigma_s: float
    """Isotropic scattering of the infill [1/mm]."""
    sigma_a: float
    """Absorption of the infill [1/mm]."""

    @property
    def sigma_t(self) -> float:
        """Extinction of the infill [1/mm]; never zero, because both passes divide by it."""
        return max(self.sigma_s + self.sigma_a, CLEAR_PER_MM)


@dataclass(slots=True, kw_only=True)
class Shapes:
    """The shapes that both passes tell apart, by their role."""

    body: Any
    infill: Any
    """All cells, or None without a grid."""
    object: Any
    """What approaches, or None."""
    triangles_per_cell: int

    @property
    def cells(self) -> int:
        """Number of cells, at least 1 so that arrays have a size."""
        return max(1, self.infill.face_count() // self.triangles_per_cell) if self.infill is not None else 1

    @property
    def object_triangles(self) -> int:
        """Number of the object's triangles, at least 1 so that arrays have a size."""
        return int(self.object.face_count()) if self.object is not None else 1

    def pointers(self) -> tuple[Any, Any, Any]:
        """Body, infill and object for comparison with hits; null, which no valid hit equals, where one is absent."""
        return mi.ShapePtr(self.body), mi.ShapePtr(self.infill), mi.ShapePtr(self.object)


@dataclass(slots=True, kw_only=True)
class Segment:
    """One stretch of a ray, classified; every field is a Dr.Jit array over rays."""

    on_infill: Any
    on_body: Any
    opaque: Any
    """The next hit is neither body nor infill."""
    in_infill: Any
    in_body: Any
    entering: Any
    """The ray arrives at its dielectric from outside."""


def classify(si: Any, body: Any, infill: Any, was_in_body: Any) -> Segment:
    """Classifies the segment that ends at an interaction.

    Args:
        si: Surface interaction at the end of the segment, valid or not.
        body: Pointer to the body's shape.
        infill: Pointer to the infill's shape, null without a grid.
        was_in_body: Memory, used only where the next hit is opaque or missing.
    """
    valid = si.is_valid()
    on_infill = valid & (si.shape == infill)
    on_body = valid & (si.shape == body)
    outside = mi.Frame3f.cos_theta(si.wi) > 0
    in_infill = on_infill & ~outside
    dielectric = on_infill | on_body
    in_body = (on_infill & outside) | (on_body & ~outside) | (~dielectric & was_in_body)
    return Segment(
        on_infill=on_infill,
        on_body=on_body,
        opaque=valid & ~dielectric,
        in_infill=in_infill,
        in_body=in_body,
        entering=outside,
    )


def fresnel(si: Any, segment: Segment, media: Media) -> tuple[Any, Any, Any, Any]:
    """Reflectance, reflected and refracted direction (local frame) at a smooth dielectric.

    Returns:
        Reflectance in 0..1, local reflected direction, local refracted direction, and the factor on radiance
        behind the interface (its solid angle changes with the square of the relative index).
    """
    cosine = mi.Frame3f.cos_theta(si.wi)
    eta = dr.select(segment.on_infill, mi.Float(media.infill_ior / media.body_ior), mi.Float(media.body_ior))
    reflectance, cosine_t, _eta_it, eta_ti = mi.fresnel(cosine, eta)
    return reflectance, mi.reflect(si.wi), mi.refract(si.wi, cosine_t, eta_ti), dr.square(eta_ti)
