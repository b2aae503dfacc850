"""What a design is judged by: names, units, and which way is better."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np

from magicsim.sampling.bootstrap import Statistic, interval
from magicsim.sweep.judging.quality import Quality

Better = Literal["higher", "lower"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureKind:
    """One measure."""

    title: str
    unit: str
    """Empty for a pure number."""
    digits: int
    """Decimals that are shown."""
    better: Better | None
    """Which way is better; None where that depends on the job."""
    is_exact: bool = False
    """Whether it follows from the design alone; equal ends of another's interval say that all resamples were alike."""
    meaning: str
    """One sentence on what is measured and what its interval stands for; `{...}` are values of the quality."""


MEASURES: dict[str, MeasureKind] = {
    "shore_a": MeasureKind(
        title="Hardness, Shore A", unit="", digits=1, better=None,
        meaning="Virtual Shore A durometer on the centre of a cell; interval: change by a coarser lattice.",
    ),
    "force_1mm_n": MeasureKind(
        title="Force at 1 mm", unit="N", digits=2, better=None,
        meaning="Force of the sweep's object pressed 1 mm; interval: largest change by coarser lattices.",
    ),
    "stiffness_n_per_mm": MeasureKind(
        title="Stiffness near 1 mm", unit="N/mm", digits=2, better=None,
        meaning="Slope of force against depth from the depth before 1 mm to 1 mm; interval as of the force.",
    ),
    "sensitivity_per_mm": MeasureKind(
        title="Sensitivity to depth", unit="1/mm", digits=3, better="higher",
        meaning="Loss of grid similarity for each mm of a light touch, from {light_depth_mm:g} to {touch_depth_mm:g} "
        "mm, mean over places; interval: bootstrap over renderings and places.",
    ),
    "sensitivity_per_n": MeasureKind(
        title="Sensitivity to force", unit="1/N", digits=3, better="higher",
        meaning="Loss of grid similarity for each newton between the same touches; interval: bootstrap over "
        "renderings and places.",
    ),
    "proximity_range_mm": MeasureKind(
        title="Proximity range", unit="mm", digits=1, better="higher",
        meaning="Distance from which half of the frames are called Approaching, with 5 % false alarms on untouched "
        "frames; interval: bootstrap over renderings and noise.",
    ),
    "contact_auc": MeasureKind(
        title="Contact AUC", unit="", digits=3, better="higher",
        meaning="Chance that a frame of a touch {light_depth_mm:g} mm deep has a lower similarity than an untouched or "
        "near one, at places that the detector was not calibrated on, lights {drift_percent:g} % stronger or weaker "
        "than then; mean over renderings, interval: bootstrap over them and places.",
    ),
    "contact_accuracy": MeasureKind(
        title="Contact accuracy", unit="", digits=3, better="higher",
        meaning="Balanced accuracy of the combined verdict on the same frames and under outside light, with the "
        "thresholds of this design; mean and interval likewise.",
    ),
    "dot_spacing_mm": MeasureKind(
        title="Smallest dot spacing", unit="mm", digits=2, better="lower",
        meaning="Smallest spacing of dots at which their pattern stands out of noise and clutter by d' = 2, not below "
        "{finest_dots_mm:g} mm; interval: bootstrap over the clutter, open where no tested spacing is on the other "
        "side.",
    ),
    "line_spacing_mm": MeasureKind(
        title="Smallest line spacing", unit="mm", digits=2, better="lower",
        meaning="Smallest spacing of lines at which their pattern stands out of noise and clutter by d' = 2, not below "
        "{finest_lines_mm:g} mm; interval: bootstrap over the clutter, open where no tested spacing is on the other "
        "side.",
    ),
    "localisation_mm": MeasureKind(
        title="Localisation error", unit="mm", digits=2, better="lower",
        meaning="Root mean square distance between a touch's place and what ridge regression on the centroids of "
        "what changes in each channel says, each place left out in turn; interval: bootstrap over "
        "renderings and places.",
    ),
    "printability": MeasureKind(
        title="Printability", unit="", digits=2, better="higher", is_exact=True,
        meaning="Share of the published printing limits that the design keeps; exact.",
    ),
    "frame_seconds": MeasureKind(
        title="Cost of a contact frame", unit="s", digits=2, better="lower",
        meaning="Time of solving a touch of {touch_depth_mm:g} mm on the design's own lattice and median time of "
        "rendering one; interval: quartiles of the rendering. Depends on the machine.",
    ),
    "unknowns": MeasureKind(
        title="Unknowns", unit="", digits=0, better="lower", is_exact=True,
        meaning="Displacement unknowns of the lattice that is solved; exact.",
    ),
}  # fmt: skip
"""All measures by their name in the results."""


def described(quality: Quality) -> dict[str, MeasureKind]:
    """All measures, their meanings with the quality's own values."""
    values = quality.model_dump() | {
        "drift_percent": 100 * quality.drift,
        "finest_dots_mm": quality.dot_spacings_mm[-1],
        "finest_lines_mm": quality.line_spacings_mm[-1],
    }
    return {name: replace(kind, meaning=kind.meaning.format_map(values)) for name, kind in MEASURES.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A measure of one design."""

    value: float | None
    """None where it could not be measured; `note` says why."""
    low: float | None = None
    """Lower end of the interval, 95 % where it is a bootstrap; None where there is none on this side."""
    high: float | None = None
    """Upper end."""
    note: str = ""
    """What a reader has to know, such as a bound instead of a value."""

    @classmethod
    def mean_over(cls, renderings: Sequence[Statistic], count: int, *, seed: int) -> Self:
        """A statistic of all items, mean over renderings, with its interval (see `interval`)."""
        low, high = interval(renderings, count, seed=seed)
        value = float(np.mean([statistic(np.arange(count)) for statistic in renderings]))
        return cls(value=value, low=low, high=high)
