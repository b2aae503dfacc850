"""Blocks that stand for a half-space or a layer: fine around the origin, coarser and coarser away from it."""

import numpy as np
import numpy.typing as npt

from magicsim.deform.lattice import Lattice, box_lattice

Array = npt.NDArray[np.float64]
SHEAR_MPA = 1.0


def spread_planes(far_mm: float, *, flat_mm: float, spacing_mm: float, spread_per_mm: float) -> Array:
    """Planes from 0 to `far_mm`, `spacing_mm` apart up to `flat_mm` and spacing_mm (1 + spread (x - flat)) beyond.

    They are a smooth map of equal steps, so that half the spacing is a refinement of the same mesh everywhere.
    """
    end = flat_mm + np.log1p(spread_per_mm * (far_mm - flat_mm)) / spread_per_mm
    step = np.linspace(0, end, round(end / spacing_mm) + 1)
    beyond = np.maximum(step - flat_mm, 0)
    return np.asarray(np.minimum(step, flat_mm) + np.expm1(spread_per_mm * beyond) / spread_per_mm)


def deep_block(
    spacing_mm: float,
    *,
    height_mm: float,
    half_width_mm: float,
    flat_mm: float,
    spread_per_mm: float,
    poisson: float,
    flat_depth_mm: float = 0.5,
) -> Lattice:
    """A block of shear modulus 1 MPa, square, bonded at z = height, with its fine part under the origin."""
    side = spread_planes(half_width_mm, flat_mm=flat_mm, spacing_mm=spacing_mm, spread_per_mm=spread_per_mm)
    across = np.concatenate([-side[:0:-1], side])
    down = spread_planes(height_mm, flat_mm=flat_depth_mm, spacing_mm=spacing_mm, spread_per_mm=spread_per_mm)
    lame = 2 * SHEAR_MPA * poisson / (1 - 2 * poisson)
    return box_lattice((across, across, down), shear_modulus_mpa=SHEAR_MPA, lame_mpa=lame)
