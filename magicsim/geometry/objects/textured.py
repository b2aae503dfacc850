"""Plates with dots or ridges on their upper face: what a user writes for them, and the shape they stand for."""

from typing import Literal, Self

from pydantic import model_validator

from magicsim.geometry.objects.rigid_object import EDGE_RADIUS_MM, SHELL_MM, SHELL_SHARE, ObjectBase, Size
from magicsim.geometry.shapes.solids import Shape
from magicsim.geometry.shapes.textured import DotPlate, Plate, RidgePlate

MAX_DOTS = 2500
"""More would not fit in memory as meshes that are round enough."""
MAX_RIDGES = 200
RIDGE_EDGE_SHARE = 0.25
"""Radius of a ridge's edges in units of its width, where none is given."""


class PlateObject(ObjectBase):
    """What plates have in common."""

    size_mm: Size = 6.0
    """Side of the square plate [mm]."""
    thickness_mm: Size = 2.0
    """Thickness of the plate without its texture [mm]."""

    def plate(self) -> Plate:
        """The plate below the texture; edges of 0.1 mm, or of a quarter of a thinner plate."""
        edge = min(EDGE_RADIUS_MM, self.thickness_mm / 4, self.size_mm / 4)
        return Plate(size_mm=self.size_mm, thickness_mm=self.thickness_mm, edge_radius_mm=edge)

    def _refuse_misfit(self, what: str, needed_mm: float, along: int, most: int, total: int) -> None:
        """One texture element must fit on the flat part, and all of them in memory."""
        if along == 0:
            msg = (
                f"size_mm = {self.size_mm:g} is not allowed: one {what} needs {needed_mm:g} mm of the "
                f"{self.plate().flat_mm:.4g} mm that are flat"
            )
            raise ValueError(msg)
        if total > most:
            msg = f"{total} {what}s are too many: at most {most}; use a larger spacing_mm or a smaller size_mm"
            raise ValueError(msg)


class DotsObject(PlateObject):
    """Hemispheres in a square array, as many as fit on the plate."""

    kind: Literal["dots"]
    radius_mm: Size
    """Radius of each hemisphere [mm]."""
    spacing_mm: Size
    """Between neighbouring centres [mm]."""

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return self.entered_from_above(self._solid(), shell_mm=min(SHELL_MM, SHELL_SHARE * self.radius_mm))

    @model_validator(mode="after")
    def _check_dots(self) -> Self:
        if self.spacing_mm <= 2 * self.radius_mm:
            msg = f"spacing_mm = {self.spacing_mm:g} is not allowed: must be above 2 radius_mm = {2 * self.radius_mm:g}"
            raise ValueError(msg)
        along = self._solid().count
        self._refuse_misfit("dot", 2 * self.radius_mm, along, MAX_DOTS, along**2)
        return self

    def _solid(self) -> DotPlate:
        return DotPlate(radius_mm=self.radius_mm, spacing_mm=self.spacing_mm, plate=self.plate())


class LinesObject(PlateObject):
    """Parallel ridges along y with grooves between them, as many as fit on the plate."""

    kind: Literal["lines"]
    width_mm: Size
    """Width of each ridge [mm]."""
    spacing_mm: Size
    """From ridge to ridge, the period [mm]."""
    height_mm: Size | None = None
    """Depth of the grooves [mm]; the width by default."""
    edge_radius_mm: Size | None = None
    """Radius of the ridges' edges, at most half of width and height [mm]; a quarter of the smaller one by default."""

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return self.entered_from_above(self._solid(), shell_mm=min(SHELL_MM, SHELL_SHARE * self.width_mm / 2))

    @model_validator(mode="after")
    def _check_ridges(self) -> Self:
        if self.spacing_mm <= self.width_mm:
            msg = f"spacing_mm = {self.spacing_mm:g} is not allowed: must be above width_mm = {self.width_mm:g}"
            raise ValueError(msg)
        most = min(self.width_mm, self._height_mm) / 2
        if self.edge_radius_mm is not None and self.edge_radius_mm > most:
            msg = f"edge_radius_mm = {self.edge_radius_mm:g} is not allowed: must be at most {most:g} mm"
            raise ValueError(msg)
        along = self._solid().count
        self._refuse_misfit("ridge", self.width_mm, along, MAX_RIDGES, along)
        return self

    @property
    def _height_mm(self) -> float:
        return self.height_mm if self.height_mm is not None else self.width_mm

    def _solid(self) -> RidgePlate:
        edge = self.edge_radius_mm or RIDGE_EDGE_SHARE * min(self.width_mm, self._height_mm)
        return RidgePlate(
            width_mm=self.width_mm,
            spacing_mm=self.spacing_mm,
            height_mm=self._height_mm,
            edge_radius_mm=edge,
            plate=self.plate(),
        )
