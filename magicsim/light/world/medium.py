"""What lies between two hits: read from the geometry of the next hit, so that no bookkeeping can go wrong.

A segment that ends on an infill cell from inside ran through that cell; one that ends on it from outside, or on
the body from inside, ran through the body. Only where the next hit is opaque, or there is none, does the caller's
memory decide. Rays displaced across an edge by the intersection offset therefore cannot carry a wrong state.
"""

from dataclasses import dataclass, replace
from typing import Any, Self

from magicsim.geometry.design import ElastomerDesign, Optics
from magicsim.geometry.printed_cells import WHOLE
from magicsim.light.backend import dr, mi
from magicsim.light.flaws.rough_surfaces import RoughSurfaces

CLEARANCE = 9e-6
"""Distance from the surface, relative to 1 mm and the largest coordinate: 0.15 micrometres at 16 mm; a thirtieth of it
still meets no surface twice. The way before a start counts as free of scattering: ten times as far off, where Mitsuba
starts rays, a white furnace is 1.0 +- 0.1 % too bright at 10 scatterings per mm, and here 0.05 +- 0.1 % (12 seeds)."""
CLEAR_PER_MM = 1e-12
"""Extinction that stands for none [1/mm]."""


@dataclass(slots=True, kw_only=True)
class Medium:
    """How one material scatters and absorbs."""

    sigma_s: float
    """Scattering coefficient [1/mm]."""
    sigma_a: float
    """Absorption coefficient [1/mm]."""
    anisotropy: float = 0.0
    """Mean cosine of the scattering angle (Henyey and Greenstein's phase function)."""

    @classmethod
    def of(cls, optics: Optics) -> Self:
        """The medium of a configured material."""
        return cls(sigma_s=optics.sigma_s_per_mm, sigma_a=optics.absorption_per_mm, anisotropy=optics.anisotropy)

    @property
    def sigma_t(self) -> float:
        """Extinction [1/mm]; never zero, because both passes divide by it."""
        return max(self.sigma_s + self.sigma_a, CLEAR_PER_MM)

    @property
    def albedo(self) -> float:
        """Share of a collision that goes on."""
        return self.sigma_s / self.sigma_t

    @property
    def reduced(self) -> "Medium":
        """Isotropic medium that spreads light alike over many collisions: sigma_s (1 - g)."""
        return Medium(sigma_s=self.sigma_s * (1 - self.anisotropy), sigma_a=self.sigma_a)


@dataclass(slots=True, kw_only=True)
class Media:
    """Optical constants of the nested media."""

    body_ior: float
    infill_ior: float
    body: Medium
    infill: Medium
    top_mm: float
    """Height above which the body's shape is the clear lens plate, which absorbs as the body does [mm]."""
    skin_roughness: float = 0.0
    """Slope that half of the facets of the block's outer faces exceed, see `flaws.rough_surfaces`."""
    wall_roughness: float = 0.0
    """Slope that half of the facets of the cells' walls exceed."""

    @classmethod
    def of(cls, design: ElastomerDesign) -> Self:
        """Media of a block: the body spreads light as an isotropic medium does, the infill as it is given."""
        body, infill = design.materials.body, design.materials.infill
        return cls(
            body_ior=body.ior,
            infill_ior=infill.ior if infill is not None else body.ior,
            body=Medium.of(body).reduced,
            infill=Medium.of(infill) if infill is not None else Medium(sigma_s=0.0, sigma_a=0.0),
            top_mm=design.height_mm,
            skin_roughness=design.roughness.skin,
            wall_roughness=design.roughness.walls,
        )

    @property
    def reduced(self) -> Self:
        """Media that all spread light as isotropic ones do."""
        return replace(self, infill=self.infill.reduced)


@dataclass(slots=True, kw_only=True)
class Coefficients:
    """A medium on the renderer's side."""

    sigma_t: Any
    sigma_a: Any
    albedo: Any
    anisotropy: float

    @classmethod
    def of(cls, medium: Medium) -> "Coefficients":
        """Opaque values: the compiled kernel then serves any material."""
        sigma_t, sigma_a, albedo = (
            dr.opaque(mi.Float, value) for value in (medium.sigma_t, medium.sigma_a, medium.albedo)
        )
        return cls(sigma_t=sigma_t, sigma_a=sigma_a, albedo=albedo, anisotropy=medium.anisotropy)


@dataclass(slots=True, kw_only=True)
class Constants:
    """Optical constants on the renderer's side."""

    body_ior: Any
    infill_ior: Any
    """Relative to the body's."""
    body: Coefficients
    infill: Coefficients
    top_mm: Any
    rough: RoughSurfaces | None
    """Interfaces that are not smooth, None where all are."""

    @classmethod
    def of(cls, media: Media) -> "Constants":
        """Opaque values, see `Coefficients`."""
        return cls(
            body_ior=dr.opaque(mi.Float, media.body_ior),
            infill_ior=dr.opaque(mi.Float, media.infill_ior / media.body_ior),
            body=Coefficients.of(media.body),
            infill=Coefficients.of(media.infill),
            top_mm=dr.opaque(mi.Float, media.top_mm),
            rough=RoughSurfaces.of(media.skin_roughness, media.wall_roughness, media.top_mm),
        )

    def eta(self, on_infill: Any) -> Any:
        """Index inside over that outside, at hits on a cell and on the body."""
        return dr.select(on_infill, self.infill_ior, self.body_ior)


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
    opening: Any = None
    """The next hit is a membrane in a missing wall, which light does not feel; None where no wall is missing."""
    beyond: Any = None
    """The cell that rays which arrive there from outside ran through."""

    @property
    def on_wall(self) -> Any:
        """The next hit is a wall of a cell."""
        return self.on_infill if self.opening is None else self.on_infill & ~self.opening


def classify(si: Any, body: Any, infill: Any, was_in_body: Any, openings: Any = None) -> Segment:
    """Classifies the segment that ends at an interaction."""
    valid = si.is_valid()
    on_infill = valid & (si.shape == infill)
    on_body = valid & (si.shape == body)
    outside = mi.Frame3f.cos_theta(si.wi) > 0
    in_infill = on_infill & ~outside
    dielectric = on_infill | on_body
    in_body = (on_infill & outside) | (on_body & ~outside) | (~dielectric & was_in_body)
    opening = beyond = None
    if openings is not None:
        beyond = dr.gather(mi.UInt32, openings, si.prim_index, on_infill)
        opening = on_infill & (beyond != WHOLE)
        in_infill |= opening
        in_body &= ~opening
    return Segment(
        on_infill=on_infill,
        on_body=on_body,
        opaque=valid & ~dielectric,
        in_infill=in_infill,
        in_body=in_body,
        entering=outside,
        opening=opening,
        beyond=beyond,
    )


def fresnel(si: Any, segment: Segment, constants: Constants) -> tuple[Any, Any, Any, Any]:
    """Reflectance, reflected and refracted direction (local frame) at a smooth dielectric; none at an opening.

    Returns:
        Reflectance in 0..1, local reflected direction, local refracted direction, and the factor on radiance
        behind the interface (its solid angle changes with the square of the relative index).
    """
    cosine = mi.Frame3f.cos_theta(si.wi)
    eta = constants.eta(segment.on_infill)
    reflectance, cosine_t, _eta_it, eta_ti = mi.fresnel(cosine, eta)
    refracted, scale = mi.refract(si.wi, cosine_t, eta_ti), dr.square(eta_ti)
    if segment.opening is not None:
        reflectance, scale = dr.select(segment.opening, 0, reflectance), dr.select(segment.opening, 1, scale)
        refracted = dr.select(segment.opening, -si.wi, refracted)
    return reflectance, mi.reflect(si.wi), refracted, scale


def scattering_stretch(ray: Any, length: Any, top_mm: Any) -> tuple[Any, Any]:
    """Part of a segment in the body's shape that lies below the lens plate: its start along the ray, and its length."""
    rising = ray.d.z >= 0
    steepness = dr.maximum(dr.abs(ray.d.z), 1e-9)
    crossing = dr.select(rising, top_mm - ray.o.z, ray.o.z - top_mm) / steepness
    start = dr.clip(dr.select(rising, 0, crossing), 0, length)
    end = dr.clip(dr.select(rising, crossing, length), start, length)
    return start, end - start


def free_path(sample: Any, transmitted: Any, sigma_t: Any) -> Any:
    """Way to a collision that happens before the segment's end: inverse of the truncated exponential."""
    return -dr.log(1 - sample * (1 - transmitted)) / sigma_t


def scattered(direction: Any, sample: Any, anisotropy: float) -> Any:
    """Direction after a collision, by Henyey and Greenstein's phase function."""
    if anisotropy == 0:
        return mi.warp.square_to_uniform_sphere(sample)
    g = anisotropy
    cosine = (1 + g**2 - dr.square((1 - g**2) / (1 - g + 2 * g * sample.x))) / (2 * g)
    sine = dr.safe_sqrt(1 - dr.square(cosine))
    azimuth = 2 * dr.pi * sample.y
    return mi.Frame3f(direction).to_world(mi.Vector3f(sine * dr.cos(azimuth), sine * dr.sin(azimuth), cosine))


def leave(si: Any, direction: Any) -> Any:
    """The ray that goes on from a hit."""
    distance = dr.mulsign(CLEARANCE * (1 + dr.max(dr.abs(si.p))), dr.dot(si.n, direction))
    return mi.Ray3f(dr.fma(distance, si.n, si.p), direction)
