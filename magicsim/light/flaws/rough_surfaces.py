"""Which interfaces of a block are rough, and how both passes cross them.

A pass decides at the first facet between what is reflected and what goes through, as it does at a smooth interface, or
follows both; `onward` then walks either out of the field. Each interface draws the random numbers of its walk from a
stream that two numbers of the path's own begin, so that a path has the same numbers whatever facets it meets.

The interface is a random height field of independent facets (Smith's model). A walk through it has the free paths and
the phase function of Heitz, Hanika, d'Eon and Dachsbacher, "Multiple-scattering microfacet BSDFs with the Smith model"
(ACM Transactions on Graphics 35, 2016): every walk leaves with weight one, and where it leaves is reciprocal, so that a
white furnace stays white. A model of single bounces loses what meets a second facet. Slopes are Trowbridge and Reitz's;
facets that a ray sees are drawn by spherical caps (Dupuy and Benyoub, Computer Graphics Forum 42, 2023).

Directions are in the local frame of a hit, and -z is where the index is `eta` times that on the other side. A height
counts as the share of the field that lies below it, and half of the facets exceed the slope `alpha`.
"""

from dataclasses import dataclass
from typing import Any, Self

from magicsim.light.backend import dr, mi

MOST_STEPS = 64
"""Flights of a walk; the few that are longer leave level with the mean surface."""
STEEP = 1e-9
"""Least square of a sine, so that no logarithm is divided by zero."""
PLATE_MM = 1e-3
"""How far below the lens plate a face belongs to the print [mm]."""


@dataclass(slots=True, kw_only=True)
class Facet:
    """The facet that a ray meets; every field is a Dr.Jit array over rays."""

    reflectance: Any
    reflected: Any
    """Direction of what it reflects, mi.Vector3f."""
    refracted: Any
    """Direction of what it lets through, mi.Vector3f."""
    height: Any


def first_facet(wi: Any, alpha: Any, eta: Any, numbers: Any) -> Facet:
    """Where a ray from afar, `wi` towards where it comes from, meets the field."""
    outside = wi.z > 0
    depth = _flown(-dr.abs(wi.z), mi.Float(1), alpha, numbers.next_float32())
    height = dr.select(outside, depth, 1 - depth)
    return _met(wi, outside, height, alpha, eta, mi.Point2f(numbers.next_float32(), numbers.next_float32()))


@dr.syntax  # type: ignore[untyped-decorator]
def walk_on(direction: Any, outside: Any, height: Any, alpha: Any, eta: Any, numbers: Any, active: Any) -> Any:
    """Direction in which a ray leaves the field after its first facet, mi.Vector3f, on the side that it points to."""
    way, above, level = mi.Vector3f(direction), mi.Bool(outside), mi.Float(height)
    steps, going = mi.UInt32(0), mi.Bool(active)
    while going:
        depth = _flown(
            dr.select(above, way.z, -way.z), dr.select(above, level, 1 - level), alpha, numbers.next_float32(going)
        )
        going &= depth < 1
        level = dr.select(above, depth, 1 - depth)
        facet = _met(
            -way, above, level, alpha, eta, mi.Point2f(numbers.next_float32(going), numbers.next_float32(going))
        )
        through = numbers.next_float32(going) >= facet.reflectance
        way = dr.select(going, dr.select(through, facet.refracted, facet.reflected), way)
        above = dr.select(going & through, ~above, above)
        steps += 1
        going &= steps < MOST_STEPS
    return mi.Vector3f(way.x, way.y, dr.select(above, dr.abs(way.z), -dr.abs(way.z)))


def _flown(cosine: Any, height: Any, alpha: Any, u: Any) -> Any:
    """Height at which a ray meets a facet, 1 or more where it leaves; both seen from its own side, `u` uniform."""
    squared = dr.square(cosine)
    spread = dr.sqrt(1 + dr.square(alpha) * dr.maximum(1 - squared, STEEP) / dr.maximum(squared, STEEP))
    # Smith's Lambda, below -1 for directions that go down and above 0 for those that go up.
    shadow = (dr.mulsign(spread, cosine) - 1) / 2
    return height * dr.exp(-dr.log(1 - u) / shadow)


def _met(wi: Any, outside: Any, height: Any, alpha: Any, eta: Any, sample: Any) -> Facet:
    """A facet that a ray sees, `wi` towards where it comes from."""
    seen = dr.select(outside, wi, -wi)
    stretched = dr.normalize(mi.Vector3f(alpha * seen.x, alpha * seen.y, seen.z))
    z = dr.fma(1 - sample.y, 1 + stretched.z, -stretched.z)
    sine, turn = dr.safe_sqrt(1 - dr.square(z)), dr.two_pi * sample.x
    half = mi.Vector3f(sine * dr.cos(turn), sine * dr.sin(turn), z) + stretched
    normal = dr.normalize(mi.Vector3f(alpha * half.x, alpha * half.y, dr.maximum(half.z, 0)))
    # A facet is seen from its own side, which rounding at its rim must not turn.
    cosine = dr.mulsign(dr.maximum(dr.abs(dr.dot(wi, normal)), STEEP), dr.select(outside, mi.Float(1), mi.Float(-1)))
    reflectance, cosine_t, _, eta_ti = mi.fresnel(cosine, eta)
    reflected = 2 * dr.dot(wi, normal) * normal - wi
    refracted = dr.normalize(mi.refract(wi, normal, cosine_t, eta_ti))
    return Facet(reflectance=reflectance, reflected=reflected, refracted=refracted, height=height)


@dataclass(slots=True, kw_only=True)
class Field:
    """Facets that rays meet; every field is a Dr.Jit array over rays."""

    is_rough: Any
    height: Any
    alpha: Any
    eta: Any
    numbers: Any


@dataclass(slots=True, kw_only=True)
class Crossing:
    """Rays at an interface, rough or not; every field is a Dr.Jit array over rays."""

    outside: Any
    """Which come from the side of +z."""
    reflectance: Any
    """Reflectance of the facet that is met, or of the smooth interface."""
    reflected: Any
    refracted: Any
    facets: Field | None
    """None where all interfaces are smooth."""

    def onward(self, local: Any, reflects: Any, active: Any) -> Any:
        """Directions in which rays leave, in the local frame, mi.Vector3f."""
        met = self.facets
        if met is None:
            return local
        above, asked = dr.select(reflects, self.outside, ~self.outside), active & met.is_rough
        left = walk_on(local, above, met.height, met.alpha, met.eta, mi.PCG32(met.numbers), asked)
        return dr.select(asked, left, local)

    def crosses(self, local: Any, reflects: Any) -> Any:
        """Which rays leave on the other side than they came from, mi.Bool."""
        return ~reflects if self.facets is None else (local.z > 0) != self.outside


@dataclass(slots=True, kw_only=True)
class RoughSurfaces:
    """Slopes that half of the facets exceed, on the renderer's side."""

    skin: Any
    walls: Any
    top_mm: Any
    """Height above which the body's shape is the lens plate, which is smooth [mm]."""

    @classmethod
    def of(cls, skin: float, walls: float, top_mm: float) -> Self | None:
        """Opaque values, so that the compiled kernel serves any roughness; None where all is smooth."""
        if skin == 0 and walls == 0:
            return None
        skin, walls, top_mm = (dr.opaque(mi.Float, value) for value in (skin, walls, top_mm))
        return cls(skin=skin, walls=walls, top_mm=top_mm)

    def met(self, si: Any, segment: Any, eta: Any, sampler: Any) -> tuple[Facet, Field]:
        """The facets that rays meet; of no meaning where an interface is smooth."""
        printed = segment.on_body & (si.p.z < self.top_mm - PLATE_MM)
        alpha = dr.select(segment.on_wall, self.walls, dr.select(printed, self.skin, 0))
        is_rough = alpha > 0
        alpha = dr.select(is_rough, alpha, 1)
        numbers = mi.PCG32()
        numbers.seed(mi.UInt64(sampler.next_uint32()), mi.UInt64(sampler.next_uint32()))
        facet = first_facet(si.wi, alpha, eta, numbers)
        return facet, Field(is_rough=is_rough, height=facet.height, alpha=alpha, eta=eta, numbers=numbers)


def crossing(
    rough: RoughSurfaces | None, si: Any, segment: Any, eta: Any, smooth: tuple[Any, Any, Any], sampler: Any
) -> Crossing:
    """What rays meet at an interface; one that is smooth takes no random number."""
    outside, (reflectance, reflected, refracted) = si.wi.z > 0, smooth
    if rough is None:
        return Crossing(
            outside=outside, reflectance=reflectance, reflected=reflected, refracted=refracted, facets=None
        )  # fmt: skip
    facet, field = rough.met(si, segment, eta, sampler)
    return Crossing(
        outside=outside,
        reflectance=dr.select(field.is_rough, facet.reflectance, reflectance),
        reflected=dr.select(field.is_rough, facet.reflected, reflected),
        refracted=dr.select(field.is_rough, facet.refracted, refracted),
        facets=field,
    )
