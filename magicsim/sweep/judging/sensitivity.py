"""How fast the grid's look changes under a light touch, and how far away an object is noticed."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.sampling.bootstrap import interval
from magicsim.sweep.judging.detector import FittedDetector
from magicsim.sweep.judging.filmed_design import Film, Shown
from magicsim.sweep.judging.measures import Measured

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
    """What one rendering of an approach looks like to a detector; all of shape (gaps,) or (gaps, draws)."""

    gaps_mm: Array
    """Falling."""
    entropy: Array
    correlation: Array
    clear_entropy: Array
    """Entropy of untouched frames, shape (frames,)."""
    tau_c: float

    def rates(self, draws: Index, clear: Index) -> Array:
        """Share of some frames called Approaching at each gap, the threshold set on some clear frames."""
        tau_e = np.quantile(self.clear_entropy[clear], 1 - FALSE_ALARMS)
        seen = (self.entropy > tau_e) & (self.correlation < self.tau_c)
        return np.asarray(seen[:, draws].mean(1))

    def all_rates(self) -> Array:
        """Rates of all frames."""
        return self.rates(np.arange(self.entropy.shape[1]), np.arange(len(self.clear_entropy)))

    def range_mm(self) -> float:
        """From where on the object is noticed (see `noticed_from`) [mm]."""
        return noticed_from(self.gaps_mm, self.all_rates())


def mean_similarity(shown: Sequence[Shown], film: Film, detector: FittedDetector, draws: int) -> Array:
    """Similarity of some states, mean over the camera's noise, shape (states,)."""
    return np.array([detector.features(film.frames(each, draws))[:, 2].mean() for each in shown])


def contact_sensitivity(light: Array, firm: Array, *, step: float, seed: int) -> Measured:
    """Loss of similarity between two light touches, mean over renderings and places.

    Places differ by how the contact lies on the grid, which is more than the camera's noise.

    Args:
        light: Similarity of the lighter touch of each place, shape (renderings, places).
        firm: Of the firmer one, of the same shape.
        step: What they differ by, in depth [mm] or force [N].
        seed: Of the bootstrap over renderings and places.
    """
    slopes = (light - firm) / step

    def mean(values: Array, places: Index) -> float:
        return float(values[places].mean())

    return Measured.mean_over([partial(mean, each) for each in slopes], slopes.shape[1], seed=seed)


def approach_curve(film: Film, detector: FittedDetector, draws: int) -> ApproachCurve:
    """Features of the approach and of untouched frames."""
    seen = np.stack([detector.features(film.frames(shown, draws)) for shown in film.approach])
    clear = detector.features(film.frames(film.untouched, CLEAR_FRAMES, first=CLEAR_FIRST))
    return ApproachCurve(
        gaps_mm=np.array([shown.gap_mm for shown in film.approach], float),
        entropy=seen[..., 0],
        correlation=seen[..., 1],
        clear_entropy=clear[:, 0],
        tau_c=detector.profile.tau_c,
    )


def proximity_range(renderings: Sequence[ApproachCurve], *, seed: int) -> Measured:
    """Distance from which on an approaching object is noticed for good, in half of the frames; mean over renderings.

    Args:
        renderings: Curve of each.
        seed: Of the bootstrap over renderings, the camera's noise, and the frames that set the threshold.
    """
    draws, clear = renderings[0].entropy.shape[1], len(renderings[0].clear_entropy)
    random = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, clear])))

    def drawn(curve: ApproachCurve, numbers: Index) -> float:
        return noticed_from(curve.gaps_mm, curve.rates(numbers, random.integers(0, clear, clear)))

    ranges = [curve.range_mm() for curve in renderings]
    value, largest = float(np.mean(ranges)), renderings[0].gaps_mm[0]
    low, high = interval([partial(drawn, curve) for curve in renderings], draws, seed=seed)
    if max(ranges) >= largest:
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
