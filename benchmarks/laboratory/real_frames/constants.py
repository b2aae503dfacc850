"""What is fitted: constants of sensor, press and camera, and their ranges."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array

RANGES = {
    "gel_scattering": (np.log(0.08), np.log(0.8)), "gel_absorption": (np.log(1e-4), np.log(0.03)),
    "coat_reflectance": (0.0, 0.3), "ring_radius": (9.0, 17.0),
}  # fmt: skip
"""Constants that are rendered, logarithms of the first two [1/mm, 1/mm, 1, mm]; the least absorption does nothing."""
LOGARITHMS = 2
DEPTH_MM = (1.2, 2.0)
GAPS_MM = (-1.3, -1.5, -1.7, -1.9)
"""Range of the depth of the press, and places of the ball that are rendered, negative when pressed."""
GAMMA, VIGNETTING = (1.0, 2.4), (0.0, 0.6)
"""Their ranges, as `Constants` has them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constants:
    """One sensor, one press, one camera."""

    scattering_per_mm: float
    absorption_per_mm: float
    coat_reflectance: float
    ring_radius_mm: float
    depth_mm: float
    vignetting: float
    """Loss at the corners of the picture."""
    exposure: float
    """Logarithm of the signal (1 is white) of a unit of radiance."""
    gamma: float
    """Of the tone curve: grey = 255 signal^(1 / gamma)."""

    @property
    def rendered(self) -> Array:
        """What a rendering depends on, as in `RANGES`."""
        return np.array(
            [np.log(self.scattering_per_mm), np.log(self.absorption_per_mm), self.coat_reflectance, self.ring_radius_mm]
        )


def from_vector(vector: Array) -> Constants:
    """The constants of a vector: logarithms of the first two."""
    first = [*np.exp(vector[:LOGARITHMS]), *vector[LOGARITHMS:]]
    return Constants(**dict(zip(Constants.__dataclass_fields__, map(float, first), strict=True)))
