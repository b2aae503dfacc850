"""Units of one kind and the surfaces that touching them gives: shapes, touches, filtering, fitting, differences."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Mask

NEIGHBOURS = 8
"""Touches that a touch is compared with."""
OUTLIER = 4.0
"""Distance from the median of its neighbours, in units of the usual one, from which a touch is left out."""
DEGREE = 4
"""Degree of the polynomial that is fitted to the touches."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitShape:
    """How the face of one unit differs from its drawing; heights are outwards, towards the object."""

    height_mm: float
    """Height of the whole face, which is the unit's thickness [mm]."""
    slope: tuple[float, ...]
    """Rise of the face for each millimetre along x and y."""
    wave_mm: float
    """Amplitude of what is left beside that [mm]."""
    wave_length_mm: float
    wave_phases: tuple[float, ...]
    """Phases of two waves along x and y, each in 0..2 pi."""
    stiffness: float

    def rise_mm(self, places_mm: Array) -> Array:
        """Height of the face over its drawing at places x, y of shape (places, 2), shape (places,) [mm]."""
        x, y = places_mm.T
        turn, first, second = 2 * np.pi / self.wave_length_mm, self.wave_phases[:2], self.wave_phases[2:]
        waves = np.sin(turn * x + first[0]) * np.sin(turn * y + first[1])
        waves += np.sin(turn * x / 2 + second[0]) * np.sin(turn * y / 2 + second[1])
        return np.asarray(self.height_mm + self.slope[0] * x + self.slope[1] * y + self.wave_mm * waves)


def touched_heights_mm(
    unit: UnitShape, places_mm: Array, depth_mm: Array, random: np.random.Generator, *, repeat_sd_mm: float,
    step_mm: float,
) -> Array:  # fmt: skip
    """Heights at which touches end: where the force reaches its threshold, on the steps of the probe, with its error.

    Args:
        places_mm: x and y of each touch, shape (touches, 2) [mm].
        depth_mm: How deep the face is pressed in at the threshold, shape (touches,) [mm].

    Returns:
        Shape (touches,) [mm], outwards.
    """
    height = unit.rise_mm(places_mm) - depth_mm
    stepped = np.floor(height / step_mm) * step_mm  # the first step at which the threshold is passed
    return np.asarray(stepped + step_mm / 2 + random.normal(0, repeat_sd_mm, len(height)))


def fitted_surface(places_mm: Array, heights_mm: Array) -> Callable[[Array], Array]:
    """A polynomial surface through touches without outliers: height [mm] at places of shape (places, 2).

    Touches have places of shape (touches, 2) and heights of shape (touches,) [mm].
    """
    scale = np.abs(places_mm).max(0)
    kept = ~outliers(places_mm, heights_mm)
    weights, *_ = np.linalg.lstsq(_powers(places_mm[kept] / scale), heights_mm[kept], rcond=None)
    return lambda places: np.asarray(_powers(places / scale) @ weights)


def outliers(places_mm: Array, heights_mm: Array) -> Mask:
    """Touches that are far from the median of their neighbours, shape (touches,)."""
    near = np.asarray(cKDTree(places_mm).query(places_mm, NEIGHBOURS + 1)[1])[:, 1:]
    apart = np.abs(heights_mm - np.median(heights_mm[near], axis=1))
    return np.asarray(apart > OUTLIER * max(float(np.median(apart)), 1e-9))


def depth_at(force_n: float, depths_mm: Array, forces_n: Array) -> float:
    """Depth at which a press reaches a force [mm]; between depths force^(2/3) is taken as linear, as Hertz has it.

    Depths increase; they and their forces [N] have the shape (depths,).
    """
    power = np.maximum(np.array([0.0, *forces_n]), 0.0) ** (2 / 3)
    return float(np.interp(force_n ** (2 / 3), power, np.array([0.0, *depths_mm])))


def _powers(places: Array) -> Array:
    x, y = places.T
    return np.stack([x**i * y**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)], 1)
