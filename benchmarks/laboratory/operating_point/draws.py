"""Points of the search: low-discrepancy ones first, then around the best that are known.

The second part is the proposal of population Monte Carlo in approximate Bayesian computation (Beaumont, Cornuet, Marin
and Robert 2009): a known good point moved by twice the spread of the good ones.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

Array = npt.NDArray[np.float64]
LEAST_SPREAD = 0.03
"""Standard deviation of a move at least, in shares of a range: good points may agree by chance."""


def first_points(count: int, dimensions: int, *, seed: int) -> Array:
    """Scrambled Sobol points of the unit cube, shape (count, dimensions); more of them begin with the same ones."""
    sampler = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    return np.asarray(sampler.random_base2(max(0, int(np.ceil(np.log2(max(count, 1))))))[:count])


def next_point(good: Sequence[Array], *, seed: int, index: int) -> Array:
    """A point of the unit cube near one of the good ones.

    Args:
        good: Good points, each of shape (dimensions,), at least one.
        seed: Of the search.
        index: Number of the point in the search; each has random numbers of its own.
    """
    random = np.random.default_rng(np.random.SeedSequence([seed, index]))
    known = np.array(good)
    spread = np.maximum(np.sqrt(2) * known.std(0), LEAST_SPREAD)
    moved = known[random.integers(len(known))] + spread * random.standard_normal(known.shape[1])
    folded = np.abs(moved) % 2
    return np.asarray(np.where(folded > 1, 2 - folded, folded))
