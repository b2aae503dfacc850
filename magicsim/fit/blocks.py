"""What images of a real sensor and of a simulated one are compared by: block means and the grid's contrast in a block.

A real camera is never aligned to a pixel, so that a difference of pixels would only tell where the grid lines lie. The
mean of a block does not know them, and neither does the spread of grey levels in it once it holds some cells.
"""

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.errors import ConfigError

LEAST_PIXELS = 4
"""Least side of a block [px]."""


def check_blocks(blocks: tuple[int, int], *, rows: int, columns: int) -> None:
    """Refuses blocks that are too small to hold a spread.

    Args:
        blocks: Down and across.
        rows: Of the image [px].
        columns: Of the image [px].

    Raises:
        ConfigError: Less than one block, or blocks of fewer than `LEAST_PIXELS` pixels.
    """
    if min(blocks) < 1 or rows // blocks[0] < LEAST_PIXELS or columns // blocks[1] < LEAST_PIXELS:
        msg = (
            f"blocks = {blocks[0]}x{blocks[1]} is not allowed: must be 1x1 to {rows // LEAST_PIXELS}x"
            f"{columns // LEAST_PIXELS} for images of {rows} rows and {columns} columns"
        )
        raise ConfigError(msg)


def block_means(image: npt.ArrayLike, blocks: tuple[int, int]) -> Array:
    """Mean of each block and channel, shape (blocks down, blocks across, 3).

    Args:
        image: Shape (rows, columns, 3).
        blocks: Down and across; where they do not divide the image, neighbours differ by one pixel.
    """
    whole = np.asarray(image, np.float64)
    parts = [np.array_split(row, blocks[1], axis=1) for row in np.array_split(whole, blocks[0], axis=0)]
    return np.array([[part.mean((0, 1)) for part in row] for row in parts])


def block_contrast(first: npt.ArrayLike, second: npt.ArrayLike, blocks: tuple[int, int]) -> Array:
    """Spread of the grey levels inside each block that two independent images have in common.

    The root of their covariance in the block: noise of either, of a camera or of a Monte Carlo rendering, does not
    enter its mean. Negative where the covariance is.

    Args:
        first: Shape (rows, columns, 3).
        second: An independent image of the same.
        blocks: Down and across.
    """
    one, other = np.asarray(first, np.float64), np.asarray(second, np.float64)
    covariance = block_means(one * other, blocks) - block_means(one, blocks) * block_means(other, blocks)
    return np.asarray(np.sign(covariance) * np.sqrt(np.abs(covariance)))
