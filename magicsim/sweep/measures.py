"""What a design is judged by: names, units, which way is better, and how much work goes into it."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self, cast

import numpy as np
from pydantic import Field

from magicsim.config.models import Config
from magicsim.judge.measures import Better, MeasureKind, Statistic, interval

Gap = Annotated[float, Field(gt=0, le=100)]
Depth = Annotated[float, Field(gt=0, le=6)]
Spacing = Annotated[float, Field(ge=0.3, le=6)]
"""Dots and lines are half as wide [mm]."""


class SweepQuality(Config):
    """Preview quality by default: small images, few particles, few positions."""

    columns: Annotated[int, Field(ge=24, le=480)] = 120
    """With `rows`, how many pixels the detectors' images have, in the shape of the rig's own; their width at 3 : 4."""
    rows: Annotated[int, Field(ge=32, le=640)] = 160
    """Likewise, their height [px]."""
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
    contact_depths_mm: tuple[Annotated[float, Field(ge=0.005, le=3)], ...] = ()
    """Further depths that contact is tested at, a curve beside the measures at `light_depth_mm` [mm]."""
    cells_across: Annotated[int, Field(ge=2, le=20)] = 8
    """Least number of lattice cells across the contact of a blunt object, whatever its depth."""
    texture_depth_mm: Depth = 0.3
    """How deep dots, lines and the plain plate are pressed from first contact [mm]."""
    texture_force_n: Annotated[float, Field(gt=0, le=100)] | None = None
    """With which force instead, but no deeper than `design.limits.depth_mm` [N]; 5 % are as near as it gets."""
    line_spacings_mm: Annotated[tuple[Spacing, ...], Field(min_length=1)] = (2.0, 1.4, 1.0)
    """Spacings of lines, falling; the finest is pressed first, and coarser ones until one is told apart [mm]."""
    dot_spacings_mm: Annotated[tuple[Spacing, ...], Field(min_length=1)] = (2.0, 1.4, 1.0)
    """Spacings of dots, falling, tried in that order [mm]."""
    texture_scale: Annotated[int, Field(ge=1, le=8)] = 1
    """Pixels of their images for each pixel of the others, along columns and along rows; more where a spacing has fewer
    than three, up to as many as the sensor's own camera has."""
    durometer_spacing_mm: Annotated[float, Field(ge=0.1, le=1)] = 0.35
    """Node spacing under the durometer's cone [mm]."""
    durometer_walls: Literal["resolved", "homogenised"] = "homogenised"
    """Whether walls below the cone are cells of their own, or part of one effective solid, which is quicker."""

    def _problems(self) -> Iterator[str | None]:
        for name, sign in (("gaps_mm", -1), ("depths_mm", 1), ("line_spacings_mm", -1), ("dot_spacings_mm", -1)):
            values = getattr(self, name)
            if any(sign * (after - before) <= 0 for before, after in pairwise(values)):
                yield f"{name} = {list(values)} is not allowed: must {'rise' if sign > 0 else 'fall'}"
        if 1.0 not in self.depths_mm[1:]:
            yield f"depths_mm = {list(self.depths_mm)} is not allowed: must hold 1.0 and a smaller value"
        if self.light_depth_mm >= self.touch_depth_mm:
            yield f"light_depth_mm = {self.light_depth_mm:g} is not allowed: must be below {self.touch_depth_mm:g}"


def _kind(title: str, unit: str, meaning: str, *, digits: str, better: str, is_exact: str) -> MeasureKind:
    way = cast("Better | None", better or None)
    return MeasureKind(title=title, meaning=meaning, unit=unit, better=way, digits=int(digits), is_exact=bool(is_exact))


with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as _file:
    MEASURES = {name: _kind(**cells) for cells in csv.DictReader(_file) if (name := cells.pop("name"))}
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
    def within(cls, value: float, half: float, note: str = "") -> Self:
        """A value whose interval reaches as far to both sides."""
        return cls(value=value, low=value - half, high=value + half, note=note)

    @classmethod
    def mean_over(cls, renderings: Sequence[Statistic], count: int, *, seed: int) -> Self:
        """A statistic of all items, mean over renderings, with its interval (see `interval`)."""
        low, high = interval(renderings, count, seed=seed)
        value = float(np.mean([statistic(np.arange(count)) for statistic in renderings]))
        return cls(value=value, low=low, high=high)
