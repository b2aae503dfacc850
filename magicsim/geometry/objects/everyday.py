"""Spanner, screwdriver, scissors and banana: what a user writes for them, and the mesh that presses."""

import atexit
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from magicsim.geometry.objects.rigid_object import SHELL_MM, SHELL_SHARE, ObjectBase, Size, check_edge
from magicsim.geometry.shapes.solids import Shape

if TYPE_CHECKING:
    from manifold3d import Manifold

    from magicsim.geometry.shapes.mesh_solid import MeshShape


@lru_cache(maxsize=8)
def _built(solid: str, dimensions: tuple[float, ...], feature_mm: float) -> "MeshShape":
    """A solid of `solids_everyday` as a shape; the last few are kept, because every frame asks for its own."""
    from magicsim.geometry.mesh import from_manifold
    from magicsim.geometry.shapes import everyday as solids_everyday
    from magicsim.geometry.shapes.mesh_solid import MeshShape

    build: Callable[..., Manifold] = getattr(solids_everyday, solid)
    return MeshShape.of(from_manifold(build(*dimensions).simplify(1e-4)), feature_mm=feature_mm)


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(_built.cache_clear)


class _Everyday(ObjectBase):
    def _solid(self, name: str, *dimensions: float, feature_mm: float) -> Shape:
        solid = _built(name, dimensions, feature_mm)
        return self.entered_from_above(solid, shell_mm=min(SHELL_MM, SHELL_SHARE * feature_mm))


class SpannerObject(_Everyday):
    """The open end of a spanner, flat in its xy plane, the jaw towards +y."""

    kind: Literal["spanner"]
    jaw_mm: Size
    """Width across flats [mm]."""
    head_radius_mm: Size = 11.0
    """Radius of the round head [mm]."""
    handle_width_mm: Size = 8.0
    """Width of the handle [mm]."""
    thickness_mm: Size = 5.0
    """Thickness [mm]."""
    edge_radius_mm: Size = 0.6
    """Radius of the outer edges [mm]."""

    def shape(self) -> Shape:
        """The solid, the head's centre at its origin."""
        return self._solid(
            "spanner_head", self.jaw_mm, self.head_radius_mm, self.handle_width_mm, self.thickness_mm,
            self.edge_radius_mm, feature_mm=self.thickness_mm / 2,
        )  # fmt: skip

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        prong = self.head_radius_mm - self.jaw_mm / 2
        check_edge(self.edge_radius_mm, prong / 2, self.thickness_mm / 2, self.handle_width_mm / 2)
        return self


class ScrewdriverObject(_Everyday):
    """The handle of a screwdriver along its y axis, with flutes and a domed butt at +y."""

    kind: Literal["screwdriver"]
    radius_mm: Size
    """Radius over the ridges [mm]."""
    length_mm: Size = 45.0
    """Length of the part that is modelled [mm]."""
    flutes: Annotated[int, Field(ge=3, le=12)] = 6
    """Number of grooves along the handle."""

    def shape(self) -> Shape:
        """The solid, centred on its origin."""
        return self._solid(
            "fluted_handle", self.radius_mm, self.length_mm, self.flutes, feature_mm=0.25 * self.radius_mm
        )

    @model_validator(mode="after")
    def _check_length(self) -> Self:
        if self.length_mm <= self.radius_mm:
            msg = f"length_mm = {self.length_mm:g} is not allowed: must be above radius_mm = {self.radius_mm:g}"
            raise ValueError(msg)
        return self


class ScissorsObject(_Everyday):
    """The finger loops of scissors, side by side in the xy plane, the arms towards +y."""

    kind: Literal["scissors"]
    tube_radius_mm: Size
    """Radius of the loops' round stock [mm]."""
    loop_width_mm: Size = 20.0
    """Width of one loop's centre line, along x [mm]."""
    loop_length_mm: Size = 30.0
    """Length of one loop's centre line, along y [mm]."""
    gap_mm: Size = 2.0
    """Free distance between the loops [mm]."""

    def shape(self) -> Shape:
        """The solid, the point between the loops at its origin."""
        return self._solid(
            "scissor_loops", self.loop_width_mm, self.loop_length_mm, self.tube_radius_mm, self.gap_mm,
            feature_mm=self.tube_radius_mm,
        )  # fmt: skip


class BananaObject(_Everyday):
    """The middle of a banana along its y axis: bent, five-sided, its outer side towards +z."""

    kind: Literal["banana"]
    radius_mm: Size
    """Radius of the circle around the section [mm]."""
    length_mm: Size = 60.0
    """Length of the part that is modelled, along the bend [mm]."""
    bend_radius_mm: Annotated[float, Field(ge=20, le=1000)] = 120.0
    """Radius of the centre line [mm]."""

    def shape(self) -> Shape:
        """The solid, the middle of its centre line at its origin."""
        return self._solid(
            "banana_section", self.radius_mm, self.length_mm, self.bend_radius_mm, feature_mm=0.4 * self.radius_mm
        )

    @model_validator(mode="after")
    def _check_bend(self) -> Self:
        if self.radius_mm >= self.bend_radius_mm or self.length_mm > 2 * self.bend_radius_mm:
            msg = (
                f"bend_radius_mm = {self.bend_radius_mm:g} is not allowed: must be above radius_mm = "
                f"{self.radius_mm:g} and at least half of length_mm = {self.length_mm:g}"
            )
            raise ValueError(msg)
        return self
