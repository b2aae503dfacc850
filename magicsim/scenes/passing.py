"""Something that passes behind what the sensor looks at: a person, a hand, in front of the room's image."""

from typing import Annotated

import numpy as np
from pydantic import Field

from magicsim.config.models import Config

STREAM = 0x9A55
"""Keeps its random numbers apart from others of a scene's seed."""
OUT_OF_SIGHT = 5.0
"""Sideways distance, in units of the distance ahead, from which on it is not there: 79 degrees from the axis."""
Reflectance = Annotated[float, Field(ge=0, le=1)]
Size = Annotated[float, Field(ge=1, le=10_000)]


class Passing(Config):
    """An upright thing with soft edges that crosses what the sensor looks at, again and again, at one speed.

    It moves along x, at one distance in front of the contact face, and hides what is behind it; its own radiance is
    that of a matt surface in the room's mean light. Times of passage and direction follow from the scene's seed. A
    person by default; all values are assumed.
    """

    distance_mm: Annotated[float, Field(ge=50, le=100_000)] = 1500.0
    """From the contact face, along the sensor's axis [mm]; what approaches the sensor has to stay before it."""
    speed_mm_s: Annotated[float, Field(ge=1, le=100_000)] = 1000.0
    """Speed [mm/s]; people walk at 1000 to 1500."""
    size_mm: tuple[Size, Size] = (450.0, 1700.0)
    """Width and height [mm]."""
    rise_mm: Annotated[float, Field(ge=-100_000, le=100_000)] = -200.0
    """Height of its middle over the sensor's axis, along y [mm]."""
    reflectance: tuple[Reflectance, Reflectance, Reflectance] = (0.12, 0.15, 0.25)
    """Diffuse reflectance, linear RGB."""
    every_s: Annotated[float, Field(ge=0.1, le=3600)] = 8.0
    """Time from one passage to the next [s]."""

    def place_mm(self, time_s: float, seed: int) -> float | None:
        """Where its middle is along x [mm], or None while it is out of sight.

        Args:
            time_s: Since the first frame of the scene [s].
            seed: Of the scene.
        """
        random = np.random.default_rng(np.random.SeedSequence([seed, STREAM]))
        begun, way = random.uniform(0, self.every_s), random.choice((-1, 1))
        place = float(way) * self.speed_mm_s * ((time_s + begun) % self.every_s - self.every_s / 2)
        return round(place, 6) if abs(place) < OUT_OF_SIGHT * self.distance_mm else None
