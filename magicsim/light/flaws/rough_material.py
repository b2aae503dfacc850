"""A rough interface for Mitsuba's own integrators, by the walk of `rough_surfaces`.

Mitsuba's `roughdielectric` follows one bounce and loses what meets a second facet, most of it in light that a block
traps. Directions that this material draws count as single ones, whose density nobody asks for.
"""

from typing import Any

from magicsim.light.backend import dr, mi
from magicsim.light.flaws.rough_surfaces import RoughSurfaces, crossing


class SingleDirections(mi.BSDF):  # type: ignore[misc]
    """Reflects (component 0) and transmits (component 1) into directions whose density nobody asks for."""

    def __init__(self, properties: Any) -> None:
        super().__init__(properties)
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [mi.BSDFFlags.DeltaReflection | both, mi.BSDFFlags.DeltaTransmission | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Nothing but single directions."""
        del context, si, wo, active
        return mi.Color3f(0)

    def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        """Nothing but single directions."""
        del context, si, wo, active
        return mi.Float(0)

    def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        """Nothing but single directions."""
        return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)


class RoughInterface(SingleDirections):
    """A dielectric that is rough below a height and smooth above it."""

    def __init__(self, properties: Any) -> None:
        """Reads `ior`, inside over outside, `alpha`, and `top_mm`, the height."""
        super().__init__(properties)
        self.ior, self.alpha = properties["ior"], properties["alpha"]
        self.surfaces = RoughSurfaces.of(self.alpha, self.alpha, properties["top_mm"])

    def sample(self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        """A direction in which light leaves, and its weight."""
        cosine, eta = mi.Frame3f.cos_theta(si.wi), mi.Float(self.ior)
        reflectance, cosine_t, eta_it, eta_ti = mi.fresnel(cosine, eta)
        smooth = reflectance, mi.reflect(si.wi), mi.refract(si.wi, cosine_t, eta_ti)
        met = crossing(self.surfaces, si, _Whole(), eta, smooth, _Bits(sample2))
        reflects = sample1 < met.reflectance
        local = met.onward(dr.select(reflects, met.reflected, met.refracted), reflects, mi.Bool(active))
        through = met.crosses(local, reflects)
        bs = dr.zeros(mi.BSDFSample3f)
        bs.pdf = mi.Float(1)
        bs.sampled_component = dr.select(through, mi.UInt32(1), mi.UInt32(0))
        bs.sampled_type = dr.select(
            through, mi.UInt32(+mi.BSDFFlags.DeltaTransmission), mi.UInt32(+mi.BSDFFlags.DeltaReflection)
        )
        bs.wo, bs.eta = local, dr.select(through, eta_it, 1)
        scale = dr.square(eta_ti) if context.mode == mi.TransportMode.Radiance else mi.Float(1)
        return bs, mi.Color3f(dr.select(through, scale, 1)) & active

    def to_string(self) -> str:
        """One line for logs."""
        return f"RoughInterface[ior={self.ior}, alpha={self.alpha}]"


class _Whole:
    """Stands for hits that are all on one body."""

    on_wall, on_body = False, True


class _Bits:
    """Two numbers of 32 bits from two of a renderer's samples, whose bits below the 24th are the other one's."""

    def __init__(self, sample: Any) -> None:
        self._values = [sample.x, sample.y]

    def next_uint32(self) -> Any:
        """The next one."""
        return dr.reinterpret_array(mi.UInt32, self._values.pop(0) + 1)


mi.register_bsdf("rough_interface", RoughInterface)


def interface_bsdf(inside: float, outside: float, alpha: float, top_mm: float) -> dict[str, Any]:
    """Entry of the interface of two clear media, smooth above a height; `alpha` as in `rough_surfaces`."""
    if alpha == 0:
        return {"type": "dielectric", "int_ior": inside, "ext_ior": outside}
    return {"type": "rough_interface", "ior": inside / outside, "alpha": alpha, "top_mm": top_mm}
