"""The smallest spacing of dots and lines that a frame still shows.

A plate with the pattern and one without are pressed alike, and D is the difference of their frames on the plate's
place in units of the untouched sensor's grey level: what only the pattern makes, the printed grid taken out. P is D's
power at the pattern's spatial frequency along its own axes, P_0 the mean power at that frequency in other directions,
where the pattern has none: noise of camera and rendering, and cells that moved otherwise. For a pattern of known
frequency and phase in Gaussian clutter

    d' = sqrt(2 (P - P_0) / P_0)

(Green and Swets 1966), 0 where P is below P_0. A spacing is told apart at d' >= 2, so P >= 3 P_0, which clutter alone
reaches in about exp(-3) = 5 % of cases.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.sampling.bootstrap import interval
from magicsim.sweep.judging.measures import Measured
from magicsim.sweep.judging.plates import LOOKED_AT_PERIODS, Pattern, PlateFrames

TOLD_APART = 2.0
"""Least d'."""
ALONG_DEG: dict[Pattern, tuple[float, ...]] = {"lines": (0.0,), "dots": (0.0, 90.0)}
"""Directions in which a pattern repeats [degrees]."""
ACROSS_DEG: dict[Pattern, tuple[float, ...]] = {
    "lines": tuple(float(each) for each in range(40, 141, 10)),
    "dots": (35.0, 40.0, 45.0, 50.0, 55.0, 125.0, 130.0, 135.0, 140.0, 145.0),
}
"""Directions in which it does not, beyond the width of its peak."""


def powers(difference: Array, places_mm: Array, directions_deg: Sequence[float], frequency_per_mm: float) -> Array:
    """Power of a difference at one frequency in several directions, mean over frames and channels.

    A Hann window over `LOOKED_AT_PERIODS` keeps the square's edges from leaking into other frequencies.

    Args:
        difference: Shape (draws, pixels, 3).
        places_mm: Of the pixels on the face, shape (pixels, 2) [mm].
        directions_deg: Of the wave, from x towards y [degrees].
        frequency_per_mm: Waves a millimetre.

    Returns:
        Shape (directions,): the square of a plane wave's amplitude.
    """
    window = np.prod(np.cos(np.pi * places_mm * frequency_per_mm / LOOKED_AT_PERIODS) ** 2, axis=1)
    turn = np.radians(directions_deg)
    along = places_mm @ np.stack([np.cos(turn), np.sin(turn)])
    waves = np.exp(2j * np.pi * frequency_per_mm * along) * window[:, None]
    found = np.einsum("pw,dpc->wdc", waves, difference, optimize=True) * 2 / window.sum()
    return np.asarray((np.abs(found) ** 2).mean((1, 2)))


def observe(with_pattern: PlateFrames, plain: PlateFrames, pattern: Pattern, spacing_mm: float) -> "Observation":
    """What the d' of one spacing is made of."""
    difference = with_pattern.contrast - plain.contrast
    return Observation(
        pattern=float(powers(difference, plain.places_mm, ALONG_DEG[pattern], 1 / spacing_mm).mean()),
        around=powers(difference, plain.places_mm, ACROSS_DEG[pattern], 1 / spacing_mm),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """Powers at one spacing."""

    pattern: float
    """P."""
    around: Array
    """In directions without the pattern, shape (directions,)."""

    def d_prime(self, directions: Index | None = None) -> float:
        """See the module; with the clutter of some directions alone."""
        clutter = float((self.around if directions is None else self.around[directions]).mean())
        return float(np.sqrt(2 * max(0.0, self.pattern - clutter) / clutter))


def try_finest_first(spacings_mm: Sequence[float], is_told_apart: Callable[[float], bool]) -> None:
    """Tries spacings from the last and finest on until one is told apart.

    Coarser ones say nothing of the smallest: a pattern near the pitch of the printed grid may be masked by it, and both
    finer and coarser ones may not.
    """
    next((spacing for spacing in reversed(spacings_mm) if is_told_apart(spacing)), None)


def smallest_spacing(spacings_mm: Array, observed: Sequence[Observation], *, seed: int) -> Measured:
    """The spacing at which d' falls to 2, between tested ones by their logarithm.

    Args:
        spacings_mm: Tried ones, falling, shape (spacings,) [mm].
        observed: One for each.
        seed: Of the bootstrap over the clutter's directions.
    """

    def crossing(directions: Index) -> float:
        return told_apart_to(spacings_mm, np.array([each.d_prime(directions) for each in observed]))

    count = len(observed[0].around)
    value = crossing(np.arange(count))
    low, high = interval([crossing], count, seed=seed)
    if value == np.inf:
        note = f"above the largest spacing tried, {spacings_mm[0]:g} mm"
        return Measured(value=None, low=float(spacings_mm[0]), note=note)
    if value <= spacings_mm[-1]:
        return Measured(value=value, high=_finite(high), note="at most: the smallest spacing tried is told apart")
    return Measured(value=value, low=_finite(low), high=_finite(high))


def told_apart_to(spacings_mm: Array, d_prime: Array) -> float:
    """Smallest spacing with a d' of 2, between the finest told apart and the next finer one [mm]; infinite without."""
    told = np.flatnonzero(d_prime >= TOLD_APART)
    if not len(told):
        return float("inf")
    last = int(told[-1])
    if last == len(d_prime) - 1:
        return float(spacings_mm[-1])
    share = (d_prime[last] - TOLD_APART) / (d_prime[last] - d_prime[last + 1])
    return float(spacings_mm[last] * (spacings_mm[last + 1] / spacings_mm[last]) ** share)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
