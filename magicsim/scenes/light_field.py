"""Light as the light pass leaves it: fluence in the cells, irradiance on the object. Linear in the lights."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

Array = npt.NDArray[np.float64]
Counts = tuple[int, int, int]
SMOOTHING_CELLS = 2.0
"""Standard deviation of the local mean [cells]: below a scattering free path of 3 mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LightField:
    """What one light, or several together, bring into the scene."""

    fluence: Array
    """Fluence of each cell and channel, shape (cells, 3)."""
    body: Array
    """Fluence of the body times what each voxel holds of it, shape (voxels, 3) [mm3]; one voxel where it is clear."""
    irradiance: Array
    """Irradiance of each of the object's triangles and channel, shape (triangles, 3)."""

    def anchored(
        self, cheap: Self, careful: Self, counts: Counts | None, voxels: Counts | None, growth: Array | float = 1.0
    ) -> "LightField":
        """The careful field, changed as much as this one differs from it, less the noise shared with the cheap one.

        What changes fluence from cell to cell is scattering over a free path of several cells, so the change is taken
        between local means: noise falls several times, and a field that equals the cheap one gives the careful one.
        Of that change the part counts that is not noise: a light touch changes fluence by less than its noise. What was
        dark takes this field's own light.

        Args:
            cheap: The untouched state with this field's seed and particles.
            careful: The untouched state with many particles.
            counts: Cells along x, y and z, or None without a grid.
            voxels: Voxels of the body along x, y and z, or None where it does not scatter.
            growth: What each voxel holds of the body over what it held when untouched, shape (voxels, 1): a voxel that
                is squeezed empty is not a dark one.
        """
        return LightField(
            fluence=_carried_over(self.fluence, cheap.fluence, careful.fluence, counts),
            body=_carried_over(self.body, growth * cheap.body, growth * careful.body, voxels),
            irradiance=self.irradiance,
        )


def _carried_over(now: Array, cheap: Array, careful: Array, counts: Counts | None) -> Array:
    if counts is None:
        return careful
    noise = cheap - careful
    share = _share(now - careful, noise, careful)
    level, change, own = (local_mean(each, counts) for each in (careful, now - careful - share * noise, noise))
    change *= _signal(change, (1 - share**2) * _energy(own, level), level)
    factor = 1 + np.divide(change, level, out=np.zeros_like(change), where=level > 0)
    return np.where(careful > 0, careful * np.maximum(factor, 0), now)


def _share(change: Array, noise: Array, level: Array) -> float:
    """Part of the noise, 0 to 1, that a change holds: regression over all values, whose variance is as their level.

    The ratio of the two noisy fields, which takes off all of the noise, adds what they do not share.
    """
    squared = _energy(noise, level)
    both = float(np.divide(change * noise, level, out=np.zeros_like(level), where=level > 0).sum())
    return float(np.clip(both / squared, 0, 1)) if squared > 0 else 0.0


def _signal(change: Array, noise: float, level: Array) -> float:
    """Part of a change that is more than noise of known energy, 0 to 1: the positive part of James and Stein (1961)."""
    energy = _energy(change, level)
    return max(0.0, 1 - noise / energy) if energy > 0 else 1.0


def _energy(values: Array, level: Array) -> float:
    """Sum of squares in units of a variance that is as the level."""
    return float(np.divide(values**2, level, out=np.zeros_like(level), where=level > 0).sum())


def local_mean(fluence: Array, counts: Counts) -> Array:
    """Gaussian mean over neighbouring cells, shape (cells, 3), cells in x-fastest order."""
    nx, ny, nz = counts
    grid = fluence.reshape(nz, ny, nx, 3)
    return gaussian_filter(grid, (SMOOTHING_CELLS,) * 3 + (0.0,), mode="nearest", truncate=2.5).reshape(-1, 3)


def total(fields: Sequence[LightField]) -> LightField:
    """Sum over lights."""
    return LightField(
        fluence=np.sum([field.fluence for field in fields], axis=0),
        body=np.sum([field.body for field in fields], axis=0),
        irradiance=np.sum([field.irradiance for field in fields], axis=0),
    )
