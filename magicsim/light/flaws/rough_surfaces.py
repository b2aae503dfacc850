"""Which interfaces of a block are rough, and how both passes cross them.

A pass decides at the first facet between what is reflected and what goes through, as it does at a smooth interface, or
follows both; `onward` then walks either out of the field. Each interface draws the random numbers of its walk from a
stream that two numbers of the path's own begin, so that a path has the same numbers whatever facets it meets.
"""

from dataclasses import dataclass
from typing import Any, Self

from magicsim.light.backend import dr, mi
from magicsim.light.flaws.facets import Facet, first_facet, walk_on

PLATE_MM = 1e-3
"""How far below the lens plate a face belongs to the print [mm]."""


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
        """Directions in which rays leave, in the local frame, mi.Vector3f.

        Args:
            local: From the facet, one of `reflected` and `refracted`.
            reflects: Which of the two.
            active: Which rays are asked for.
        """
        met = self.facets
        if met is None:
            return local
        above, asked = dr.select(reflects, self.outside, ~self.outside), active & met.is_rough
        left = walk_on(local, above, met.height, met.alpha, met.eta, mi.PCG32(met.numbers), asked)
        return dr.select(asked, left, local)

    def crosses(self, local: Any, reflects: Any) -> Any:
        """Which rays leave on the other side than they came from, mi.Bool.

        Args:
            local: Directions in which they leave.
            reflects: Which were reflected by the first facet.
        """
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
        """The facets that rays meet; of no meaning where an interface is smooth.

        Args:
            si: The hits.
            segment: What ends there.
            eta: Index inside over that outside.
            sampler: Of the paths, which gives two numbers.
        """
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
    """What rays meet at an interface; one that is smooth takes no random number.

    Args:
        rough: Which interfaces are rough, or None where all are smooth.
        si: The hits.
        segment: What ends there, a `Segment`.
        eta: Index inside over that outside.
        smooth: Reflectance, reflected and refracted direction of smooth interfaces.
        sampler: Of the paths.
    """
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
