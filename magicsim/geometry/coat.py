"""Cover of the contact face: an opaque coat or a half mirror. Configuration of `[coat]` in a design.

A coat with a thickness and a modulus stiffens the face as a membrane (`magicsim.deform.lattice.membrane`); without them
it is seen and not felt.
"""

from collections.abc import Iterator
from math import cbrt
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config

Share = Annotated[float, Field(ge=0, le=1)]
Color = tuple[Share, Share, Share]
THICKEST_SHARE = 0.1
"""Part of the block's height that a coat may be thick: the height that it adds is left out."""
STIFFEST_MM = 0.25
"""Largest length over which a coat's bending may count: contacts are a few times as wide [mm]."""


class Sheet(Config):
    """Stiffness of a coat: a thin elastic layer, or none where neither number is given."""

    thickness_mm: Annotated[float, Field(ge=0.001, le=0.5)] | None = None
    """Thickness, at most a tenth of the block's height; given together with `modulus_mpa` [mm]."""
    modulus_mpa: Annotated[float, Field(ge=0.001, le=100)] | None = None
    """Young's modulus; the coat is incompressible [MPa]."""

    @property
    def shear_n_per_mm(self) -> float:
        """Thickness times shear modulus E / 3 [N/mm]; 0 where the coat has no stiffness."""
        return (self.thickness_mm or 0.0) * (self.modulus_mpa or 0.0) / 3

    def wrinkle_mm(self, body_mpa: float) -> float:
        """Length of the coat's wrinkles over 2 pi, h (E_c / 3 E_b)^(1/3), on a deep body as incompressible as it [mm].

        Over much more than that its bending does not count (Chen and Hutchinson, J. Appl. Mech. 71 (2004) 597).
        """
        return (self.thickness_mm or 0.0) * cbrt((self.modulus_mpa or 0.0) / (3 * body_mpa))

    def problem(self, height_mm: float, body_mpa: float) -> str | None:
        """Why a block of a height and of a body's Young's modulus cannot have this coat, or None where it can."""
        if self.thickness_mm is None or self.modulus_mpa is None:
            return None
        if self.thickness_mm > THICKEST_SHARE * height_mm:
            return (
                f"coat.thickness_mm = {self.thickness_mm:g} is not allowed: must be at most "
                f"{THICKEST_SHARE * height_mm:.4g}, {THICKEST_SHARE:g} of the block's height of {height_mm:g} mm"
            )
        wrinkle = self.wrinkle_mm(body_mpa)
        if wrinkle > STIFFEST_MM:
            return (
                f"coat.modulus_mpa = {self.modulus_mpa:g} is not allowed with coat.thickness_mm = "
                f"{self.thickness_mm:g}: bending, which is left out, would count over {wrinkle:.2g} mm, "
                f"thickness_mm * (modulus_mpa / 3 youngs_modulus_mpa)^(1/3); must be at most {STIFFEST_MM:g} mm"
            )
        return None

    def _problems(self) -> Iterator[str | None]:
        if (self.thickness_mm is None) != (self.modulus_mpa is None):
            missing, given = ("thickness_mm", "modulus_mpa")[:: 1 if self.thickness_mm is None else -1]
            yield f"{missing} is missing: a coat with {given} needs both, one without stiffness neither"


class OpaqueCoat(Sheet):
    """A pigmented layer: what is outside is not seen, the face is."""

    kind: Literal["opaque"]
    color: Color = (0.5, 0.5, 0.5)
    """Diffuse reflectance in linear RGB, seen from within the body."""
    specular: Share = 0.0
    """Share of the light that it mirrors, as flakes of metal do; the rest meets the diffuse ground."""
    roughness: Annotated[float, Field(ge=0.02, le=1)] = 0.3
    """Root mean square slope of the facets that mirror."""


class HalfMirror(Sheet):
    """A metal film so thin that some light passes: tactile under bright lights, see-through under dim ones."""

    kind: Literal["half_mirror"]
    reflectance: Annotated[float, Field(ge=0, le=0.98)]
    """Share of light that the film alone reflects, 0..1, at any angle."""
    transmittance: Annotated[float, Field(ge=0, le=1)]
    """Share of light that the film alone lets through, 0..1; what is neither reflected nor transmitted is absorbed."""

    def _problems(self) -> Iterator[str | None]:
        yield from super()._problems()
        if not 0 < self.reflectance + self.transmittance <= 1:
            yield (
                f"reflectance + transmittance = {self.reflectance + self.transmittance:g} is not allowed: must be "
                "above 0 and at most 1"
            )


Coat = Annotated[OpaqueCoat | HalfMirror, Field(discriminator="kind")]
