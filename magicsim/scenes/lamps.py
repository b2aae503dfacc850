"""Lights beside the strips: single LEDs outside the block, and a ring behind the window. Part of a rig."""

from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from magicsim.config.models import Config

FARTHEST_MM = 2000.0
"""Half of a room's width [mm]: what is further away matters to no frame."""
PlaceMm = Annotated[float, Field(ge=-FARTHEST_MM, le=FARTHEST_MM)]
FAINTEST, BRIGHTEST = 1e-6, 1000.0
"""Radiances that light particles still carry without losing digits, beside 0."""


def _not_faint(radiance: float) -> float:
    if 0 < radiance < FAINTEST:
        raise ValueError(f"{radiance:g} is not allowed: must be 0 (off) or a number of at least {FAINTEST:g}")
    return radiance


Radiance = Annotated[float, Field(ge=0, le=BRIGHTEST), AfterValidator(_not_faint)]
"""In units that only compare lights with each other: exposure makes up for all of them. 0 is a light that is off."""
Rgb = tuple[Radiance, Radiance, Radiance]
Vector = tuple[PlaceMm, PlaceMm, PlaceMm]
Lobe = Annotated[float, Field(ge=1, le=200)]
"""Exponent of the cosine that the intensity falls with; 1 is a matte emitter, a bare die, or one under a diffuser."""


class Led(Config):
    """One LED: a small disk in the air around the block."""

    place_mm: Vector
    """Centre of the disk; the contact face is at z = 0, block and plate above it [mm]."""
    direction: Vector
    """Where it shines; any length but 0."""
    radiance: Rgb
    """Along its axis, relative units."""
    radius_mm: Annotated[float, Field(ge=0.05, le=20)] = 0.5
    """Radius of the disk [mm]."""
    lobe: Lobe = 1.0
    """Exponent m: intensity falls as cos^m of the angle from the axis; half of it is left at 60 degrees with 1, at 33
    with 4, at 21 with 10."""

    @model_validator(mode="after")
    def _check_direction(self) -> Self:
        if not any(self.direction):
            raise ValueError(f"direction = {list(self.direction)} is not allowed: must not be 0")
        return self

    @property
    def axis(self) -> tuple[float, float, float]:
        """Unit vector along which it shines."""
        x, y, z = (np.array(self.direction) / np.linalg.norm(self.direction)).tolist()
        return x, y, z

    def problem(self, number: int, footprint_mm: tuple[float, float], top_mm: float) -> str | None:
        """Why a block cannot have this LED beside it, or None where it can.

        Args:
            number: Place in the list.
            footprint_mm: Size of the block along x and y [mm].
            top_mm: Outer face of the lens plate [mm].
        """
        reach = self.radius_mm * np.sqrt(np.maximum(1 - np.square(self.axis), 0))
        low, high = np.array(self.place_mm) - reach, np.array(self.place_mm) + reach
        half = np.array(footprint_mm) / 2
        if (high[:2] > -half).all() and (low[:2] < half).all() and high[2] > 0 and low[2] < top_mm:
            return (
                f"rig.leds.{number}.place_mm = {list(self.place_mm)} is not allowed: must be outside of the block and "
                f"its plate, {footprint_mm[0]:g} x {footprint_mm[1]:g} mm and z from 0 to {top_mm:g}"
            )
        return None


class LedRing(Config):
    """A ring around the camera's view that shines through the window: even under a diffuser, or single LEDs."""

    radiance: Rgb
    """Towards the block, relative units."""
    radius_mm: Annotated[float, Field(ge=0.5, le=500)]
    """Mean radius [mm]."""
    width_mm: Annotated[float, Field(ge=0.1, le=100)] = 2.0
    """Width of the even ring, or diameter of each LED [mm]."""
    gap_mm: Annotated[float, Field(ge=0.05, le=500)] = 1.0
    """Distance behind the lens plate [mm]."""
    leds: Annotated[int, Field(ge=0, le=200)] = 0
    """Number of LEDs; 0 is an even ring, LEDs under a diffuser."""
    lobe: Lobe = 1.0
    """Exponent of the cosine that the intensity falls with, see `Led.lobe`."""

    @model_validator(mode="after")
    def _check_width(self) -> Self:
        if self.width_mm / 2 >= self.radius_mm:
            msg = f"width_mm = {self.width_mm:g} is not allowed: must be below twice radius_mm = {self.radius_mm:g}"
            raise ValueError(msg)
        return self
