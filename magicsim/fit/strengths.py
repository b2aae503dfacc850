"""What images of a real sensor and of a simulated one are compared by, and strengths of the lights from it.

A real camera is never aligned to a pixel, so that a difference of pixels would only tell where the grid lines lie. The
mean of a block does not know them, and neither does the spread of grey levels in it once it holds some cells.

Light adds up, so the strengths of the lights follow from block means by linear least squares. Where some unknowns enter
linearly they are solved for inside the search of the others (variable projection: Golub and Pereyra 1973). Exposure and
strength are one number here: only their product reaches the image.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls

from magicsim.arrays import Array, FloatImage
from magicsim.errors import ConfigError

LEAST_PIXELS = 4
"""Least side of a block [px]."""


def check_blocks(blocks: tuple[int, int], *, rows: int, columns: int) -> None:
    """Refuses (`ConfigError`) less than one block, or blocks of fewer than `LEAST_PIXELS` pixels."""
    if min(blocks) < 1 or rows // blocks[0] < LEAST_PIXELS or columns // blocks[1] < LEAST_PIXELS:
        raise ConfigError(
            f"blocks = {blocks[0]}x{blocks[1]} is not allowed: must be 1x1 to {rows // LEAST_PIXELS}x"
            f"{columns // LEAST_PIXELS} for images of {rows} rows and {columns} columns"
        )


def block_means(image: npt.ArrayLike, blocks: tuple[int, int]) -> Array:
    """Mean of each block and channel, shape (blocks down, blocks across, 3)."""
    whole = np.asarray(image, np.float64)
    parts = [np.array_split(row, blocks[1], axis=1) for row in np.array_split(whole, blocks[0], axis=0)]
    return np.array([[part.mean((0, 1)) for part in row] for row in parts])


def block_contrast(first: npt.ArrayLike, second: npt.ArrayLike, blocks: tuple[int, int]) -> Array:
    """Spread of the grey levels inside each block that two independent images have in common.

    The root of their covariance in the block: noise of either, of a camera or of a Monte Carlo rendering, does not
    enter its mean. Negative where the covariance is.
    """
    one, other = np.asarray(first, np.float64), np.asarray(second, np.float64)
    covariance = block_means(one * other, blocks) - block_means(one, blocks) * block_means(other, blocks)
    return np.asarray(np.sign(covariance) * np.sqrt(np.abs(covariance)))


Basis = Mapping[str, FloatImage]
"""One linear radiance image for each light, shape (rows, columns, 3)."""
Key = tuple[str, int]
"""A light and a channel of it."""
DARKEST = 0.5 / 255
"""Signals below half a grey level count as that, where the tone curve has no slope."""


Strengths = Mapping[Key, float]
"""What each light's channel is multiplied with to give the camera's signal, 1 at grey level 255."""


def lit_signal(strengths: Strengths, basis: Basis, matrix: Array) -> Array:
    """The camera's linear signal, shape (rows, columns, 3); the colour matrix has shape (3, 3)."""
    light = np.zeros(next(iter(basis.values())).shape)
    for (name, channel), strength in strengths.items():
        if name in basis:
            light[..., channel] += strength * basis[name][..., channel]
    return np.asarray(light @ matrix.T)


def lit_channels(bases: Sequence[Basis]) -> list[Key]:
    """Lights and channels that bring any light in any state."""
    names = list(dict.fromkeys(name for basis in bases for name in basis))
    return [
        (name, channel)
        for name in names
        for channel in range(3)
        if any(name in basis and basis[name][..., channel].max() > 0 for basis in bases)
    ]


def fit_strengths(
    bases: Sequence[Basis], signals: Sequence[Array], matrix: Array, *, blocks: tuple[int, int], gamma: float
) -> Strengths:
    """The strengths, none negative, whose block means come closest to the observed ones in grey levels.

    Signals have shape (rows, columns, 3) for each state, the camera's colour matrix (3, 3); a difference of signals
    counts by the slope of the tone curve `gamma`.
    """
    keys = lit_channels(bases)
    columns, wanted, slopes = [], [], []
    for basis, signal in zip(bases, signals, strict=True):
        seen = block_means(signal, blocks)
        slopes.append((255 / gamma * np.maximum(seen, DARKEST) ** (1 / gamma - 1)).ravel())
        wanted.append(seen.ravel())
        columns.append(np.stack([_column(basis, key, matrix, blocks) for key in keys], axis=1))
    weight = np.concatenate(slopes)
    solved, _ = nnls(np.concatenate(columns) * weight[:, None], np.concatenate(wanted) * weight)
    return dict(zip(keys, solved.tolist(), strict=True))


def _column(basis: Basis, key: Key, matrix: Array, blocks: tuple[int, int]) -> Array:
    """Block means of all channels of the signal for one light's channel at strength 1, flattened."""
    name, channel = key
    if name not in basis:
        return np.zeros(3 * blocks[0] * blocks[1])
    light = block_means(basis[name][..., channel : channel + 1], blocks)
    return np.asarray(light * matrix[:, channel]).ravel()
