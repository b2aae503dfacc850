"""Light of a frame, anchored to the untouched sensor: its careful light and what the frame changes beyond noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from magicsim.light.transport.light_field import LightField

Array = npt.NDArray[np.float64]
Counts = tuple[int, int, int]
SMOOTHING_CELLS = 2.0
"""Standard deviation of the local mean [cells]: below a scattering free path of 3 mm."""


def anchored_light(
    now: Mapping[str, LightField],
    cheap: Mapping[str, LightField],
    careful: Mapping[str, LightField],
    counts: Counts | None,
    voxels: Counts | None,
    growth: Array | float = 1.0,
) -> dict[str, LightField]:
    """The careful fields, changed as much as a frame's differ from them, less the noise shared with the cheap ones.

    What changes fluence from cell to cell is scattering over a free path of several cells, so the change is taken
    between local means: noise falls several times, and fields that equal the cheap ones give the careful ones.
    Of that change the part counts that is not noise: a light touch changes fluence by less than its noise. What was
    dark takes the frame's own light.

    Args:
        now: Each light's field in the frame.
        cheap: In the untouched state with the frame's seed and particles.
        careful: In the untouched state with many particles.
        counts: Cells along x, y and z, or None without a grid.
        voxels: Voxels of the body along x, y and z, or None where it does not scatter.
        growth: What each voxel holds of the body over what it held when untouched, shape (voxels, 1): a voxel that
            is squeezed empty is not a dark one.
    """
    states = {name: (now[name], cheap[name], careful[name]) for name in now}
    fluence = _carried_over([(a.fluence, b.fluence, c.fluence) for a, b, c in states.values()], counts)
    body = _carried_over([(a.body, growth * b.body, growth * c.body) for a, b, c in states.values()], voxels)
    return {
        name: replace(now[name], fluence=in_cells, body=in_voxels)
        for name, in_cells, in_voxels in zip(now, fluence, body, strict=True)
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class _Change:
    """By what one light's field differs from the careful one, between local means of shape (cells, 3)."""

    level: Array
    """The careful field."""
    mean: float
    """Relative change of the whole field."""
    mean_noise: float
    """Variance of that, from one sample of it."""
    rest: Array
    """Change of each cell beside that."""
    rest_noise: float
    """Energy of the noise in that."""

    @classmethod
    def between(cls, now: Array, cheap: Array, careful: Array, counts: Counts) -> Self:
        noise = cheap - careful
        share = _share(now - careful, noise, careful)
        level, change, own = (_local_mean(each, counts) for each in (careful, now - careful - share * noise, noise))
        mean, mean_own = (_ratio(each.sum(), level.sum()) for each in (change, own))
        unshared = 1 - share**2
        return cls(
            level=level,
            mean=float(mean),
            mean_noise=float(unshared * mean_own**2),
            rest=change - mean * level,
            rest_noise=unshared * _energy(own - mean_own * level, level),
        )

    def factor(self, mean_part: float) -> Array:
        """By what the careful field is multiplied, where of the change of the whole a part counts."""
        rest_part = _signal(_energy(self.rest, self.level), self.rest_noise)
        return 1 + mean_part * self.mean + rest_part * _ratio(self.rest, self.level)


def _carried_over(fields: Sequence[tuple[Array, Array, Array]], counts: Counts | None) -> list[Array]:
    """The careful field of each of several lights, carried over to the frame."""
    if counts is None:
        return [careful for _, _, careful in fields]
    changes = [_Change.between(*each, counts) for each in fields]
    mean_part = _signal(sum(one.mean**2 for one in changes), sum(one.mean_noise for one in changes))
    return [
        np.where(careful > 0, careful * np.maximum(change.factor(mean_part), 0), now)
        for change, (now, _, careful) in zip(changes, fields, strict=True)
    ]


def _share(change: Array, noise: Array, level: Array) -> float:
    """Part of the noise, 0 to 1, that a change holds: regression over all values, whose variance is as their level.

    The ratio of the two noisy fields, which takes off all of the noise, adds what they do not share.
    """
    squared = _energy(noise, level)
    return float(np.clip(_ratio(change * noise, level).sum() / squared, 0, 1)) if squared > 0 else 0.0


def _signal(energy: float, noise: float) -> float:
    """Part of a change that is more than noise of known energy, 0 to 1: the positive part of James and Stein (1961)."""
    return max(0.0, 1 - noise / energy) if energy > 0 else 1.0


def _energy(values: Array, level: Array) -> float:
    """Sum of squares in units of a variance that is as the level."""
    return float(_ratio(values**2, level).sum())


def _ratio(values: Array, level: Array) -> Array:
    return np.divide(values, level, out=np.zeros_like(level), where=level > 0)


def _local_mean(fluence: Array, counts: Counts) -> Array:
    """Gaussian mean over neighbouring cells, shape (cells, 3), cells in x-fastest order."""
    nx, ny, nz = counts
    grid = fluence.reshape(nz, ny, nx, 3)
    return gaussian_filter(grid, (SMOOTHING_CELLS,) * 3 + (0.0,), mode="nearest", truncate=2.5).reshape(-1, 3)
