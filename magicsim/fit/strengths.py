"""Strengths of the lights from block means: light adds up, so they follow by linear least squares.

Where some unknowns enter linearly they are solved for inside the search of the others (variable projection: Golub and
Pereyra 1973). Exposure and strength are one number here: only their product reaches the image.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from magicsim.arrays import Array, FloatImage
from magicsim.fit.blocks import block_means

Basis = Mapping[str, FloatImage]
"""One linear radiance image for each light, shape (rows, columns, 3)."""
Key = tuple[str, int]
"""A light and a channel of it."""
DARKEST = 0.5 / 255
"""Signals below half a grey level count as that, where the tone curve has no slope."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Strengths:
    """What each light's channel is multiplied with to give the camera's signal, 1 at grey level 255."""

    of: dict[Key, float]

    def signal(self, basis: Basis, matrix: Array) -> Array:
        """The camera's linear signal, shape (rows, columns, 3).

        Args:
            basis: Of one state; its lights may be fewer.
            matrix: Colour matrix of the camera, shape (3, 3).
        """
        shape = next(iter(basis.values())).shape
        light = np.zeros(shape)
        for (name, channel), strength in self.of.items():
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

    Args:
        bases: Of each state.
        signals: Observed linear signal of each state, shape (rows, columns, 3).
        matrix: Colour matrix of the camera, shape (3, 3).
        blocks: Down and across.
        gamma: Of the tone curve, by whose slope a difference of signals counts.
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
    return Strengths(of=dict(zip(keys, solved.tolist(), strict=True)))


def _column(basis: Basis, key: Key, matrix: Array, blocks: tuple[int, int]) -> Array:
    """Block means of all channels of the signal for one light's channel at strength 1, flattened."""
    name, channel = key
    if name not in basis:
        return np.zeros(3 * blocks[0] * blocks[1])
    light = block_means(basis[name][..., channel : channel + 1], blocks)
    return np.asarray(light * matrix[:, channel]).ravel()
