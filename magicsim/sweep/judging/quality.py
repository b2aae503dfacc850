"""How much work goes into judging one design."""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config

Gap = Annotated[float, Field(gt=0, le=100)]
Depth = Annotated[float, Field(gt=0, le=6)]
Spacing = Annotated[float, Field(ge=1, le=6)]
"""Finer patterns than twice the triangles of the rendered face are not shown by it [mm]."""


class Quality(Config):
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
    """Its light particles."""
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
                msg = f"{name} = {list(values)} is not allowed: must {'rise' if sign > 0 else 'fall'}"
                raise ValueError(msg)
        if 1.0 not in self.depths_mm[1:]:
            msg = f"depths_mm = {list(self.depths_mm)} is not allowed: must hold 1.0 and a smaller value"
            raise ValueError(msg)
        if self.light_depth_mm >= self.touch_depth_mm:
            msg = f"light_depth_mm = {self.light_depth_mm:g} is not allowed: must be below {self.touch_depth_mm:g}"
            raise ValueError(msg)
        return self
