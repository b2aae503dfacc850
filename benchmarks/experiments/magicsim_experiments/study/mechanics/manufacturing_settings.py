"""Settings of the study `manufacturing`."""

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim_experiments.study.settings import StudyConfig
from magicsim_experiments.study.study_file import named_table

Spread = Annotated[float, Field(ge=0, le=5)]
Share = Annotated[float, Field(gt=0, le=0.98)]


class UnitTolerances(Config):
    """Standard deviations between units of one kind; assumed."""

    thickness_sd_mm: Spread
    """Standard deviation of the height of the block [mm]."""
    slope_sd_deg: Annotated[float, Field(ge=0, le=10)]
    """Standard deviation of the slope of the face along each axis [degrees]."""
    wave_sd_mm: Spread
    """Standard deviation of what is left of the face's shape beside that [mm]."""
    wave_length_mm: Annotated[float, Field(ge=1, le=100)] = 12.0
    """Length of its waves [mm]."""
    stiffness_sd: Annotated[float, Field(ge=0, le=0.3)] = 0.03
    """Standard deviation of the factor on the moduli."""


class Probe(Config):
    """What touches the units."""

    threshold_n: Annotated[float, Field(gt=0, le=20)] = 0.2
    """Normal force at which a touch ends [N]."""
    repeat_sd_mm: Annotated[float, Field(ge=0, le=1)] = 0.01
    """Standard deviation of its place along z [mm]; assumed."""
    step_mm: Annotated[float, Field(gt=0, le=1)] = 0.01
    """Steps in which it advances [mm]; assumed."""


class ManufacturingConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["manufacturing"]
    moulded_design: ElastomerDesign
    """The moulded gel that the design is compared with; a file may give the name of a design preset."""
    object: ObjectConfig
    """What touches."""
    units: Annotated[int, Field(ge=2, le=50)] = 6
    draws: Annotated[int, Field(ge=1, le=1000)] = 10
    """Sets of units that are drawn: intervals are over them, matrices are of the first."""
    touches: Annotated[int, Field(ge=50, le=10_000)] = 400
    """Random touches of each unit."""
    place_share: Share = 0.9
    """Part of the face along each axis that is touched."""
    probe: Probe = Probe()
    printed: UnitTolerances
    moulded: UnitTolerances
    depths_mm: Annotated[tuple[Annotated[float, Field(gt=0, le=5)], ...], Field(min_length=2, max_length=20)]
    """Depths at which presses are solved, increasing; the last one's force has to pass the threshold."""
    places_across: Annotated[int, Field(ge=2, le=7)] = 3
    """Places along each axis, from the middle of the face to the end of what is touched, at which they are solved."""

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The moulded design put in place."""
        return data | {"moulded_design": named_table(data.get("moulded_design", "gelsight-type"), "design", folder)}

    @model_validator(mode="after")
    def _check_depths(self) -> Self:
        if any(later <= earlier for earlier, later in pairwise(self.depths_mm)):
            msg = f"depths_mm = {list(self.depths_mm)} is not allowed: must increase"
            raise ValueError(msg)
        return self
