"""Surface of the object: a diffuse reflectance, one for all or one a vertex, and a share of light that it mirrors.

Light meets either the mirror, a rough conductor without losses (Trowbridge and Reitz's microfacets), or the diffuse
ground. Both estimators use the same model, so that each can judge the other.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.rigid_object import ObjectBase
from magicsim.light.backend import dr, mi

COLORS = "vertex_color"
"""Attribute of the object's mesh that holds one reflectance a vertex."""
GREY = (0.7, 0.7, 0.7)
"""Diffuse reflectance of an object without a colour of its own."""


@dataclass(slots=True, kw_only=True)
class Finish:
    """How an object looks."""

    color: tuple[float, float, float] = GREY
    """Diffuse reflectance in linear RGB; ignored where vertices have their own."""
    vertex_colors: bool = False
    """Whether the object's mesh holds them."""
    specular: float = 0.0
    """Share of the light that is mirrored."""
    roughness: float = 0.2
    """Roughness of the mirror: the root mean square slope of its facets."""

    is_ghost: bool = False
    """Whether light passes as if nothing were there: it must leave every image as it is, which tests the estimator."""

    @classmethod
    def of(cls, solid: ObjectBase, mesh: SurfaceMesh) -> Self:
        """Finish of a configured object; its mesh brings the colours of vertices where these come from a file."""
        own = mesh.colors is not None
        return cls(color=solid.color, vertex_colors=own, specular=solid.specular, roughness=solid.roughness)

    def bsdf(self) -> dict[str, Any]:
        """Entry of the scene's dictionary."""
        if self.is_ghost:
            return {"type": "null"}
        color = (
            {"type": "mesh_attribute", "name": COLORS}
            if self.vertex_colors
            else {"type": "rgb", "value": list(self.color)}
        )
        diffuse = {"type": "diffuse", "reflectance": color}
        if self.specular == 0:
            return diffuse
        mirror = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": self.roughness}
        return {"type": "blendbsdf", "weight": self.specular, "first": diffuse, "second": mirror}

    def diffuse(self, si: Any, active: Any) -> Any:
        """Radiance that the diffuse ground sends out for each unit of irradiance."""
        # Opaque: the compiled kernel then serves any object.
        own = [dr.opaque(mi.Float, value) for value in self.color]
        color = si.shape.eval_attribute_3(COLORS, si, active) if self.vertex_colors else mi.Color3f(*own)
        return mi.Color3f(color) * dr.opaque(mi.Float, (1 - self.specular) / np.pi)

    def mirror(self, si: Any, sample: Any) -> tuple[Any, Any]:
        """A mirrored direction in the local frame, and its weight, 0 where nothing is mirrored."""
        if self.specular == 0:
            return mi.Vector3f(0, 0, 1), mi.Float(0)
        roughness, share = dr.opaque(mi.Float, self.roughness), dr.opaque(mi.Float, self.specular)
        facets = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, roughness, sample_visible=True)
        normal, _ = facets.sample(si.wi, sample)
        direction = mi.reflect(si.wi, normal)
        lit = (mi.Frame3f.cos_theta(direction) > 0) & (mi.Frame3f.cos_theta(si.wi) > 0)
        return direction, dr.select(lit, share * facets.smith_g1(direction, normal), 0)
