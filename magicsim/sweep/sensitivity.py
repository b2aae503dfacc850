"""How fast the grid's look changes under a light touch, and how far away an object is noticed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.sweep.bootstrap import Indices, interval
from magicsim.sweep.detector import FittedDetector
from magicsim.sweep.film import Film, Shown
from magicsim.sweep.measures import Measured

Array = npt.NDArray[np.float64]
FALSE_ALARMS = 0.05
"""Share of untouched frames that are called Approaching."""
CLEAR_FRAMES = 120
"""Untouched frames that set the threshold for it."""
CLEAR_FIRST = 200
"""Their first noise stream, beyond those of the detector's training."""
DETECTED = 0.5
"""Share of frames that makes an object noticed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ApproachCurve:
    """What an approach looks like to a detector; all of shape (gaps,) or (gaps, renderings, draws)."""

    gaps_mm: Array
    """Falling."""
    entropy: Array
    correlation: Array
    clear_entropy: Array
    """Of untouched frames, shape (frames,)."""
    tau_c: float

    def rates(self, renderings: Indices, draws: Indices, clear: Indices) -> Array:
        """Share of some frames called Approaching at each gap, the threshold set on some clear frames."""
        tau_e = np.quantile(self.clear_entropy[clear], 1 - FALSE_ALARMS)
        seen = (self.entropy > tau_e) & (self.correlation < self.tau_c)
        return np.asarray(seen[:, renderings][:, :, draws].mean((1, 2)))

    def all_rates(self) -> Array:
        """The same of all frames."""
        counts = (*self.entropy.shape[1:], len(self.clear_entropy))
        return self.rates(*(np.arange(count) for count in counts))


def mean_similarity(shown: Sequence[Shown], film: Film, detector: FittedDetector, draws: int) -> Array:
    """Similarity of some states, mean over the camera's noise, shape (states,)."""
    return np.array([detector.features(film.frames(each, draws))[:, 2].mean() for each in shown])


def contact_sensitivity(light: Array, firm: Array, *, step: float, seed: int) -> Measured:
    """Loss of similarity between two light touches, mean over places.

    Places differ by how the contact lies on the grid, which is more than the camera's noise.

    Args:
        light: Similarity of the lighter touch of each place, shape (places,).
        firm: Of the firmer one, shape (places,).
        step: What they differ by, in depth [mm] or force [N].
        seed: Of the bootstrap over places.
    """
    slopes = (light - firm) / step

    def slope(places: Indices) -> float:
        return float(slopes[places].mean())

    low, high = interval(slope, len(slopes), seed=seed)
    return Measured(value=slope(np.arange(len(slopes))), low=low, high=high)


def approach_curve(film: Film, detector: FittedDetector, draws: int) -> ApproachCurve:
    """Features of the approach and of untouched frames."""
    renderings = (film.approach, *film.approach_again)
    features = [[detector.features(film.frames(shown, draws)) for shown in each] for each in renderings]
    seen = np.stack(features, axis=1)
    clear = detector.features(film.frames(film.untouched, CLEAR_FRAMES, first=CLEAR_FIRST))
    return ApproachCurve(
        gaps_mm=np.array([shown.gap_mm for shown in film.approach], float),
        entropy=seen[..., 0],
        correlation=seen[..., 1],
        clear_entropy=clear[:, 0],
        tau_c=detector.profile.tau_c,
    )


def proximity_range(curve: ApproachCurve, *, seed: int) -> Measured:
    """Distance from which on an approaching object is noticed for good, in half of the frames."""
    _, renderings, draws = curve.entropy.shape
    clear = len(curve.clear_entropy)
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, clear])))

    def drawn(numbers: Indices) -> float:
        chosen, untouched = (random.integers(0, count, count) for count in (renderings, clear))
        return noticed_from(curve.gaps_mm, curve.rates(chosen, numbers, untouched))

    value = noticed_from(curve.gaps_mm, curve.all_rates())
    low, high = interval(drawn, draws, seed=seed)
    if value >= curve.gaps_mm[0]:
        return Measured(value=value, low=low, high=None, note="at least: noticed at the largest distance tried")
    note = "not noticed at any distance tried" if value == 0 else ""
    return Measured(value=value, low=low, high=high, note=note)


def noticed_from(gaps_mm: Array, rates: Array) -> float:
    """Largest gap from which on inwards the rate stays at one half or more, between gaps by their logarithm [mm].

    Args:
        gaps_mm: Falling, shape (gaps,) [mm].
        rates: Shape (gaps,).

    Returns:
        0 where the rate is below one half at the smallest gap.
    """
    missed = np.flatnonzero(rates < DETECTED)
    if not len(missed):
        return float(gaps_mm[0])
    last = int(missed[-1])
    if last == len(gaps_mm) - 1:
        return 0.0
    share = (DETECTED - rates[last]) / (rates[last + 1] - rates[last])
    return float(np.exp(np.log(gaps_mm[last]) + share * np.log(gaps_mm[last + 1] / gaps_mm[last])))
