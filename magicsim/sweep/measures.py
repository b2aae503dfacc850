"""What a design is judged by: names, units, which way is better, and how much work goes into it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from magicsim.config.models import Config
from magicsim.judge.intervals import Statistic, interval
from magicsim.judge.measures import MeasureKind

Gap = Annotated[float, Field(gt=0, le=100)]
Depth = Annotated[float, Field(gt=0, le=6)]
Spacing = Annotated[float, Field(ge=1, le=6)]
"""Finer patterns than twice the triangles of the rendered face are not shown by it [mm]."""


class SweepQuality(Config):
    """Preview quality by default: small images, few particles, few positions."""

    columns: Annotated[int, Field(ge=24, le=480)] = 120
    """Width of the images that the detectors see [px]."""
    rows: Annotated[int, Field(ge=32, le=640)] = 160
    """Their height [px]."""
    samples: Annotated[int, Field(ge=1, le=256)] = 8
    """Camera samples a pixel."""
    particles: Annotated[int, Field(ge=1000, le=10_000_000)] = 30_000
    """Light particles a frame."""
    anchor_samples: Annotated[int, Field(ge=1, le=4096)] = 24
    """Camera samples of the untouched state, which all frames share."""
    anchor_particles: Annotated[int, Field(ge=1000, le=100_000_000)] = 200_000
    """Light particles of the untouched state."""
    renderings: Annotated[int, Field(ge=1, le=20)] = 2
    """Renderings of every frame for image measures, each with random numbers, references and thresholds of its
    own, so that the rendering's noise is in the intervals."""
    draws: Annotated[int, Field(ge=4, le=200)] = 12
    """Frames with camera noise of their own that every state is seen in."""
    drift: Annotated[float, Field(ge=0, le=0.5)] = 0.02
    """Standard deviation of the lights' strength in the test of contact, as a share of that at calibration; assumed."""
    gaps_mm: Annotated[tuple[Gap, ...], Field(min_length=3)] = (100.0, 70.0, 50.0, 35.0, 25.0, 15.0, 6.0, 2.0)
    """Distances of the approach, falling [mm]."""
    depths_mm: Annotated[tuple[Depth, ...], Field(min_length=2)] = (0.1, 0.3, 0.6, 1.0)
    """Depths of the press, rising; 1 mm is one of them, and not the first [mm]."""
    touches: Annotated[int, Field(ge=6, le=200)] = 12
    """Places that are touched, for sensitivity, localisation and the detector's calibration and test."""
    light_depth_mm: Annotated[float, Field(ge=0.02, le=3)] = 0.1
    """How deep they are touched lightly: what the detector is tested on, and where sensitivity begins [mm]."""
    touch_depth_mm: Annotated[float, Field(ge=0.02, le=3)] = 0.3
    """How deep they are touched firmly: what is localised, and where sensitivity ends [mm]."""
    cells_across: Annotated[int, Field(ge=2, le=20)] = 8
    """Least number of lattice cells across the contact of a blunt object, whatever its depth."""
    texture_depth_mm: Depth = 0.3
    """How deep dots, lines and the plain plate are pressed from first contact [mm]."""
    line_spacings_mm: Annotated[tuple[Spacing, ...], Field(min_length=1)] = (2.0, 1.4, 1.0)
    """Spacings of lines, falling; the finest is pressed first, and coarser ones until one is told apart [mm]."""
    dot_spacings_mm: Annotated[tuple[Spacing, ...], Field(min_length=1)] = (2.0, 1.4, 1.0)
    """Spacings of dots, falling, tried in that order [mm]."""
    texture_scale: Annotated[int, Field(ge=1, le=8)] = 1
    """Pixels of their images for each pixel of the others, along columns and along rows."""
    durometer_spacing_mm: Annotated[float, Field(ge=0.1, le=1)] = 0.35
    """Node spacing under the durometer's cone [mm]."""
    durometer_walls: Literal["resolved", "homogenised"] = "homogenised"
    """Whether walls below the cone are cells of their own, or part of one effective solid, which is quicker."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        for name, sign in (("gaps_mm", -1), ("depths_mm", 1), ("line_spacings_mm", -1), ("dot_spacings_mm", -1)):
            values = getattr(self, name)
            if any(sign * (after - before) <= 0 for before, after in pairwise(values)):
                raise ValueError(f"{name} = {list(values)} is not allowed: must {'rise' if sign > 0 else 'fall'}")
        if 1.0 not in self.depths_mm[1:]:
            raise ValueError(f"depths_mm = {list(self.depths_mm)} is not allowed: must hold 1.0 and a smaller value")
        if self.light_depth_mm >= self.touch_depth_mm:
            msg = f"light_depth_mm = {self.light_depth_mm:g} is not allowed: must be below {self.touch_depth_mm:g}"
            raise ValueError(msg)
        return self


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
    "force_at_yield_n": MeasureKind(
        title="Force at yield", unit="N", digits=2, better="higher",
        meaning="Force of the sweep's object at which the infill begins to flow, at its lowest yield stress in the "
        "design's limits; interval: change by a coarser lattice.",
    ),
    "force_at_tear_n": MeasureKind(
        title="Force at tear", unit="N", digits=2, better="higher",
        meaning="Force at which the skin tears, by stretch or stress at the lowest strengths in the design's limits; "
        "interval likewise. Elastic: what fails before it changes nothing.",
    ),
    "safe_depth_mm": MeasureKind(
        title="Safe depth", unit="mm", digits=2, better="higher",
        meaning="Depth of the sweep's object at which the infill yields or the skin tears, whichever is first, at the "
        "lowest strengths; interval likewise.",
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
DURABILITY = {"force_at_yield_n": "yield", "force_at_tear_n": "tear", "safe_depth_mm": None}
"""Measures of what a print bears, and which event each is about; minutes a design, so that a sweep has to name them."""


def described(quality: SweepQuality) -> dict[str, MeasureKind]:
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
