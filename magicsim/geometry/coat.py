"""What covers the contact face: an opaque coat or a half mirror. Configuration of `[coat]` in a design.

Both are optical alone: their stiffness is left out.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config

Share = Annotated[float, Field(ge=0, le=1)]
Color = tuple[Share, Share, Share]


class OpaqueCoat(Config):
    """A pigmented layer: what is outside is not seen, the face is."""

    kind: Literal["opaque"]
    color: Color = (0.5, 0.5, 0.5)
    """Diffuse reflectance in linear RGB, seen from within the body."""
    specular: Share = 0.0
    """Share of the light that it mirrors, as flakes of metal do; the rest meets the diffuse ground."""
    roughness: Annotated[float, Field(ge=0.02, le=1)] = 0.3
    """Root mean square slope of the facets that mirror."""


class HalfMirror(Config):
    """A metal film so thin that some light passes: tactile under bright lights, see-through under dim ones."""

    kind: Literal["half_mirror"]
    reflectance: Annotated[float, Field(ge=0, le=0.98)]
    """Share of light that the film alone reflects, 0..1, at any angle."""
    transmittance: Annotated[float, Field(ge=0, le=1)]
    """Share of light that the film alone lets through, 0..1; what is neither reflected nor transmitted is absorbed."""

    @model_validator(mode="after")
    def _check_energy(self) -> Self:
        if not 0 < self.reflectance + self.transmittance <= 1:
            msg = (
                f"reflectance + transmittance = {self.reflectance + self.transmittance:g} is not allowed: must be "
                "above 0 and at most 1"
            )
            raise ValueError(msg)
        return self


Coat = Annotated[OpaqueCoat | HalfMirror, Field(discriminator="kind")]


def film_on_face(reflectance: float, transmittance: float, bare: float, *, inside: bool) -> tuple[float, float]:
    """Reflectance and transmittance of a face with a film of metal on its inner side, incoherent between both.

    The film and the bare face reflect light to and fro: the geometric series of parallel plates.

    Args:
        reflectance: Of the film alone.
        transmittance: Of the film alone.
        bare: Reflectance of the face without it, by Fresnel's formula; 1 beyond the critical angle.
        inside: Whether light arrives from within the body.
    """
    series = 1 / (1 - reflectance * bare)
    through = transmittance * (1 - bare) * series
    if inside:
        return reflectance + transmittance**2 * bare * series, through
    return bare + (1 - bare) ** 2 * reflectance * series, through
