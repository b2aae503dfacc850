"""Materials for Mitsuba's own integrators: rough interfaces, and a coated or marked contact face, a shape of its own.

Mitsuba's `roughdielectric` follows one bounce and loses what meets a second facet, most of it in light that a block
traps; a rough interface is the walk of `rough_surfaces`. Directions that these materials draw count as single ones,
whose density nobody asks for.
"""

from typing import Any

import numpy as np

from magicsim.geometry.coat import HalfMirror, OpaqueCoat
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.face_paint import FacePaint, face_paint
from magicsim.geometry.mesh import SurfaceMesh
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

    def _drawn(self, context: Any, local: Any, through: Any, density: Any, eta_it: Any, eta_ti: Any) -> tuple[Any, Any]:
        """A sample in some directions, part of which go through, and the factor on radiance behind the interface."""
        bs = dr.zeros(mi.BSDFSample3f)
        bs.wo, bs.pdf, bs.eta = local, density, dr.select(through, eta_it, 1)
        bs.sampled_component = dr.select(through, mi.UInt32(1), mi.UInt32(0))
        bs.sampled_type = dr.select(
            through, mi.UInt32(+mi.BSDFFlags.DeltaTransmission), mi.UInt32(+mi.BSDFFlags.DeltaReflection)
        )
        scale = dr.square(eta_ti) if context.mode == mi.TransportMode.Radiance else mi.Float(1)
        return bs, dr.select(through, scale, 1)


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
        bs, scale = self._drawn(context, local, through, mi.Float(1), eta_it, eta_ti)
        return bs, mi.Color3f(scale) & active


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


class FilmedDielectric(SingleDirections):
    """A smooth dielectric with a film of metal inside, incoherent: the geometric series of parallel plates."""

    def __init__(self, properties: Any) -> None:
        """Reads `ior`, `reflectance` and `transmittance`."""
        super().__init__(properties)
        self.ior = properties["ior"]
        self.own, self.passed = properties["reflectance"], properties["transmittance"]

    def sample(self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        """A reflected or refracted direction and its weight."""
        del sample2
        cosine = mi.Frame3f.cos_theta(si.wi)
        bare, cosine_t, eta_it, eta_ti = mi.fresnel(cosine, mi.Float(self.ior))
        series = dr.rcp(1 - self.own * bare)
        inner = self.own + self.passed**2 * bare * series
        outer = bare + dr.square(1 - bare) * self.own * series
        back, through = dr.select(cosine > 0, outer, inner), self.passed * (1 - bare) * series
        kept = back + through
        reflected = sample1 * kept < back
        local = dr.select(reflected, mi.reflect(si.wi), mi.refract(si.wi, cosine_t, eta_ti))
        density = dr.select(reflected, back, through) / dr.maximum(kept, 1e-9)
        bs, scale = self._drawn(context, local, ~reflected, density, eta_it, eta_ti)
        return bs, mi.Color3f(kept * scale) & active


mi.register_bsdf("filmed_dielectric", FilmedDielectric)


def face_bsdf(elastomer: Elastomer) -> dict[str, Any]:
    """Entry of the face's material in a scene's dictionary."""
    design, paint = elastomer.design, face_paint(elastomer.design)
    clear = interface_bsdf(design.materials.body.ior, 1.0, design.roughness.skin, design.height_mm)
    if isinstance(design.coat, HalfMirror):
        coat = design.coat
        clear = {
            "type": "filmed_dielectric",
            "ior": design.materials.body.ior,
            "reflectance": coat.reflectance,
            "transmittance": coat.transmittance,
        }
    if paint is None:
        return clear
    ground: dict[str, Any] = {"type": "diffuse", "reflectance": _bitmap(paint, slice(0, 3))}
    if isinstance(design.coat, OpaqueCoat) and design.coat.specular > 0:
        alpha = design.coat.roughness
        mirror = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
        ground = {"type": "blendbsdf", "weight": design.coat.specular, "first": ground, "second": mirror}
    painted = {"type": "twosided", "bsdf": ground}
    if design.is_opaque:
        return painted
    return {"type": "blendbsdf", "weight": _bitmap(paint, slice(3, 4)), "first": clear, "second": painted}


def _bitmap(paint: FacePaint, channels: slice) -> dict[str, Any]:
    data = np.ascontiguousarray(paint.texels[..., channels], np.float32)
    return {"type": "bitmap", "data": mi.TensorXf(data), "raw": True, "filter_type": "bilinear", "wrap_mode": "clamp"}


def face_places(elastomer: Elastomer) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Texture coordinates of the body's vertices, 0..1 over the paint, shape (vertices, 2)."""
    paint = face_paint(elastomer.design)
    if paint is None:
        return np.zeros((len(elastomer.body.vertices), 2))
    rows, columns = paint.texels.shape[:2]
    places = (elastomer.body.vertices[:, :2] - paint.origin_mm) / paint.pixel_mm
    return np.asarray(places / [columns, rows])


def parted(elastomer: Elastomer) -> tuple[SurfaceMesh, SurfaceMesh]:
    """The body's surface without its contact face, and that alone; both keep all vertices."""
    mesh = elastomer.body
    on_face = elastomer.is_face[mesh.faces].all(1)
    rest, face = (SurfaceMesh(vertices=mesh.vertices, faces=mesh.faces[part]) for part in (~on_face, on_face))
    return rest, face
