"""Paired permutation test of several measures at once (Westfall and Young 1993, step-down minima of p-values).

Both runs of a unit are exchanged together in every measure, so the correction knows how the measures hang together:
measures that fall together count as one, where Bonferroni or Holm would ask each to pay for the others.
"""

from itertools import product

import numpy as np

from magicsim.arrays import Array, Mask

EXCHANGES = 8192
"""Exchanges that are tried: all of them up to 13 units, as many random ones beyond."""
DECIMALS = 10
"""To which statistics are compared: sums in another order must compare as equal."""


def exchanges(units: int, *, seed: int) -> Mask:
    """Which units are exchanged, shape (exchanges, units); the first row, what was observed, exchanges none."""
    if 2**units <= EXCHANGES:
        return np.array(list(product([False, True], repeat=units)), bool).reshape(-1, units)
    drawn = np.random.default_rng(seed).random((EXCHANGES, units)) < 0.5  # noqa: PLR2004
    drawn[0] = False
    return drawn


def p_values(statistics: Array) -> Array:
    """Share of exchanges with a statistic at least as large, for every exchange and measure.

    Args:
        statistics: One row an exchange, one column a measure; large is against the hypothesis.

    Returns:
        Shape (exchanges, measures), in 0..1.
    """
    rounded = np.round(statistics, DECIMALS)
    columns = [1 - np.searchsorted(np.sort(column), column, side="left") / len(column) for column in rounded.T]
    return np.stack(columns, axis=1) if columns else np.empty(statistics.shape)


def corrected(p: Array) -> Array:
    """p-values of the observed row, corrected for all measures together, shape (measures,).

    The smallest one is compared with the smallest of all measures in every exchange, the next with the smallest of all
    but the first, and so on; none becomes smaller than the one before (Ge, Dudoit and Speed 2003).
    """
    order = np.argsort(p[0], kind="stable")
    result, highest = np.ones(p.shape[1]), 0.0
    for rank, place in enumerate(order):
        least = p[:, order[rank:]].min(axis=1)
        highest = max(highest, float((least <= p[0, place] + 10.0**-DECIMALS).mean()))
        result[place] = highest
    return result
