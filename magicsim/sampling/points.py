"""Points of the unit cube from which everything random is drawn; point k never depends on how many there are."""

import math
from typing import Literal

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
BELOW_ONE = np.nextafter(1.0, 0.0)


def unit_points(count: int, dimensions: int, *, seed: int, stream: int, sampling: Literal["sobol", "random"]) -> Array:
    """The first points of a sequence.

    Args:
        count: How many.
        dimensions: Of each point.
        seed: Seed of the recipe or sweep.
        stream: Sequences of different streams are independent.
        sampling: Scrambled Sobol points (Owen 1998), or independent ones.

    Returns:
        Shape (count, dimensions), in [0, 1).
    """
    if dimensions == 0 or count == 0:
        return np.zeros((count, dimensions))
    if sampling == "random":
        streams = [np.random.SeedSequence([seed, stream, index]) for index in range(count)]
        return np.stack([np.random.Generator(np.random.PCG64(each)).random(dimensions) for each in streams])
    from scipy.stats import qmc

    scramble = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, stream])))
    whole = 2 ** math.ceil(math.log2(count))  # Sobol points are balanced in powers of two
    points = qmc.Sobol(dimensions, scramble=True, rng=scramble).random(whole)[:count]
    return np.asarray(np.minimum(points, BELOW_ONE))
