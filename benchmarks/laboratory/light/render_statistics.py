"""Errors of Monte Carlo images judged by independent images alone: no method is trusted.

All measures are of the central image (see `refinement.central`) and in units of its mean. Standard errors are those of
the jackknife: leave out one image, or one pair, at a time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from magicsim.arrays import Array
from magicsim.light.plain_renderer import central

BLOCK_PX = 20
"""Edge of the blocks that two methods are compared on."""
LEVEL = 0.05
"""Chance that any of all blocks exceeds the bound though the methods agree."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A value and its standard error."""

    value: float
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockComparison:
    """Means over blocks of pixels, by two methods."""

    worst: float
    """Difference, relative to the block, where it is largest beside what is allowed."""
    bound: float
    """Largest that chance explains over all blocks (Sidak, Student's t), relative to the same block."""
    beyond: int
    """Blocks that differ by more than their bound, and by more than `SMALL`."""
    blocks: int


SMALL = 0.01
"""Relative difference of a block that is accepted whatever its bound."""


def spread(images: Sequence[Array]) -> Estimate:
    """Relative root mean square error of one image, from at least three independent ones without a common bias."""
    stack = _stack(images)

    def measure(chosen: Array) -> float:
        return float(np.sqrt(chosen.var(0, ddof=1).mean()) / chosen.mean())

    return _jackknife(stack, measure)


def deviation(first: Sequence[Array], second: Sequence[Array]) -> Estimate:
    """Relative root mean square error of one image of the first method, what all its images share included.

    From the second method's mean, whose own noise is taken off: images that share a fixed pattern of samples spread
    less than they err.

    Args:
        first: At least three images.
        second: As many of a method without a common error, independent of the first.
    """
    pairs = np.stack([_stack(first), _stack(second)], 1)

    def measure(chosen: Array) -> float:
        ours, theirs = chosen[:, 0], chosen[:, 1]
        square = ((ours - theirs.mean(0)) ** 2).mean() - theirs.var(0, ddof=1).mean() / len(theirs)
        return float(np.sqrt(max(square, 0.0)) / theirs.mean())

    return _jackknife(pairs, measure)


def bias(first: Sequence[Array], second: Sequence[Array]) -> Estimate:
    """Relative root mean square difference of two methods' expectations, by cross products of independent pairs.

    (f1 - p1)(f2 - p2) has the square of the difference as its mean, whatever the noise; negative means are kept as the
    negative root, so that the estimate of no bias is as often below as above zero.
    """
    differences = _stack(first) - _stack(second)
    size = float(_stack(first).mean())

    def measure(chosen: Array) -> float:
        count, total = len(chosen), chosen.sum(0)
        cross = float(((total**2 - (chosen**2).sum(0)) / (count * (count - 1))).mean())
        return float(np.sign(cross) * np.sqrt(abs(cross)) / size)

    return _jackknife(differences, measure)


def mean_difference(first: Sequence[Array], second: Sequence[Array]) -> list[Estimate]:
    """Mean radiance of each channel by the first method over that of the second, less one."""
    ours, theirs = (np.stack([image.mean((0, 1)) for image in images]) for images in (first, second))
    ratio = ours.mean(0) / theirs.mean(0)
    relative = [(each.std(0, ddof=1) / np.sqrt(len(each)) / each.mean(0)) ** 2 for each in (ours, theirs)]
    errors = ratio * np.sqrt(sum(relative))
    return [Estimate(value=float(r - 1), error=float(e)) for r, e in zip(ratio, errors, strict=True)]


def compare_blocks(first: Sequence[Array], second: Sequence[Array]) -> BlockComparison:
    """Blocks of pixels by two methods, with standard errors from their independent images."""
    ours, theirs = (np.stack([_blocks(central(image)) for image in images]) for images in (first, second))
    scale = theirs.mean(0)
    difference = ours.mean(0) - scale
    parts = [(each.var(0, ddof=1) / len(each), len(each) - 1) for each in (ours, theirs)]
    variance = sum(part for part, _ in parts)
    freedom = variance**2 / sum(part**2 / count for part, count in parts)  # Welch and Satterthwaite
    level = 1 - (1 - LEVEL) ** (1 / difference.size)
    bound = stats.t.ppf(1 - level / 2, freedom) * np.sqrt(variance)
    relative, allowed = np.abs(difference) / scale, bound / scale
    worst = int((relative / np.maximum(allowed, SMALL)).argmax())
    return BlockComparison(
        worst=float(relative.flat[worst]),
        bound=float(allowed.flat[worst]),
        beyond=int((relative > np.maximum(allowed, SMALL)).sum()),
        blocks=difference.size,
    )


def _blocks(image: Array) -> Array:
    """Means over whole blocks, shape (rows // BLOCK_PX, columns // BLOCK_PX, 3)."""
    rows, columns = (size // BLOCK_PX for size in image.shape[:2])
    cut = image[: rows * BLOCK_PX, : columns * BLOCK_PX]
    return np.asarray(cut.reshape(rows, BLOCK_PX, columns, BLOCK_PX, -1).mean((1, 3)))


def _stack(images: Sequence[Array]) -> Array:
    return np.stack([central(np.asarray(image, np.float64)) for image in images])


def _jackknife(stack: Array, measure: Callable[[Array], float]) -> Estimate:
    count = len(stack)
    left = np.array([measure(np.delete(stack, number, axis=0)) for number in range(count)])
    error = float(np.sqrt((count - 1) / count * ((left - left.mean()) ** 2).sum()))
    return Estimate(value=measure(stack), error=error)
