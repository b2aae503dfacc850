"""Settings of the study `limits`."""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.config.models import Config
from magicsim.geometry.design import ElastomerDesign
from magicsim_experiments.study.protocol import StudyConfig

Length = Annotated[float, Field(gt=0, le=25)]
Depths = Annotated[tuple[Length, ...], Field(min_length=1, max_length=200)]
Friction = Annotated[float, Field(ge=0, le=5)]
Spacing = Annotated[float, Field(ge=0.1, le=5)]
Margin = Annotated[float, Field(ge=0, le=5)]
Stress = Annotated[float, Field(gt=0, le=10)]


class YieldStress(Config):
    """Shear stress at which the infill begins to flow; assumed, with a range."""

    low_mpa: Stress
    mpa: Stress
    high_mpa: Stress

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if not self.low_mpa <= self.mpa <= self.high_mpa:
            msg = (
                f"low_mpa = {self.low_mpa:g}, mpa = {self.mpa:g}, high_mpa = {self.high_mpa:g} are not allowed: must "
                "not decrease"
            )
            raise ValueError(msg)
        return self

    @property
    def each(self) -> tuple[float, float, float]:
        """Lowest, middle and highest [MPa]."""
        return self.low_mpa, self.mpa, self.high_mpa


class Cells(Config):
    """Presses above the middle of a cell with resolved walls, of which a quarter is solved."""

    depths_mm: Depths
    spacing_mm: Spacing = 0.4
    margin_mm: Margin = 0.85


class Beside(Config):
    """Presses beside the middle of a cell with resolved walls, of which the whole block is solved."""

    x_mm: Annotated[float, Field(ge=-3, le=3)]
    y_mm: Annotated[float, Field(ge=-3, le=3)]
    diameters_mm: tuple[Length, ...]
    skins_mm: tuple[Length, ...]
    depths_mm: Depths
    spacing_mm: Spacing = 0.45
    margin_mm: Margin = 0.5


class Sheared(Config):
    """Presses that are then sheared along x."""

    diameter_mm: Length
    skin_mm: Length
    paths_mm: tuple[tuple[Length, Length], ...]
    """Depth and shear of each."""
    spacing_mm: Spacing = 0.5


class LimitsConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["limits"]
    diameters_mm: Annotated[tuple[Length, ...], Field(min_length=1, max_length=20)]
    """Diameters of the domed cylinders."""
    skins_mm: Annotated[tuple[Length, ...], Field(min_length=1, max_length=20)]
    """Thicknesses that the design's skin is given; its core stays."""
    depths_mm: Depths
    """Depths of each press, increasing."""
    friction: Friction = 1.0
    infill_yield: YieldStress
    cells: Cells | None = None
    beside: Beside | None = None
    sheared: Sheared | None = None

    @model_validator(mode="after")
    def _check_depths(self) -> Self:
        for name, depths in self.paths_mm.items():
            if any(later <= earlier for earlier, later in pairwise(depths)):
                msg = f"{name} = {list(depths)} is not allowed: must increase"
                raise ValueError(msg)
        return self

    @property
    def paths_mm(self) -> dict[str, tuple[float, ...]]:
        """Depths of the presses by the key that gives them."""
        more = {"cells": self.cells, "beside": self.beside}
        return {"depths_mm": self.depths_mm} | {
            f"{key}.depths_mm": each.depths_mm for key, each in more.items() if each
        }

    def with_skin(self, skin_mm: float) -> ElastomerDesign:
        """The design with another skin."""
        return ElastomerDesign.model_validate(self.design.model_dump() | {"skin_mm": skin_mm})
