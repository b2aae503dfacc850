"""Spanner, screwdriver, scissors, banana and meshes of files: what a user writes for them, and the mesh that presses.

Each solid is closed and outward; of those by name edges are rounded where skin would touch them, and only the part near
the sensor is modelled.
"""

import atexit
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from manifold3d import CrossSection, JoinType, Manifold, OpType
from pydantic import Field

from magicsim.arrays import Array
from magicsim.config.named_files import FileName
from magicsim.errors import ConfigError
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.rigid_object import ObjectBase, Size, edge_problem
from magicsim.geometry.shapes.solids import Shape

if TYPE_CHECKING:
    from magicsim.geometry.shapes.mesh_solid import MeshShape

CIRCLE = 96
"""Segments of the large circles of a section."""
BALL = 24
"""Segments of the balls that round edges and sweep tubes."""


def spanner_head(
    jaw_mm: float, head_radius_mm: float, handle_width_mm: float, thickness_mm: float, edge_radius_mm: float
) -> Manifold:
    """The open end of a spanner, flat in the xy plane, its jaw towards +y, turned by 15 degrees (`SpannerObject`)."""
    length = 2.5 * head_radius_mm
    slot = CrossSection.square((jaw_mm, 2 * head_radius_mm), center=True).translate((0, 0.6 * head_radius_mm))
    handle = CrossSection.square((handle_width_mm, length), center=True).translate((0, -length / 2))
    outline = CrossSection.circle(head_radius_mm, CIRCLE) - slot.rotate(15) + handle
    core = outline.offset(-edge_radius_mm, JoinType.Miter).simplify(0.02)
    flat = Manifold.extrude(core, thickness_mm - 2 * edge_radius_mm)
    flat = flat.translate((0, 0, edge_radius_mm - thickness_mm / 2))
    return flat.minkowski_sum(Manifold.sphere(edge_radius_mm, 12))


def fluted_handle(radius_mm: float, length_mm: float, flutes: int) -> Manifold:
    """A screwdriver's handle along y with lengthwise flutes, its butt at +y a dome (`ScrewdriverObject`)."""
    groove = CrossSection.circle(0.55 * radius_mm, CIRCLE // 2).translate((1.42 * radius_mm, 0))
    section = CrossSection.circle(radius_mm, CIRCLE)
    for number in range(flutes):
        section -= groove.rotate(360 * (number + 0.5) / flutes)
    rounding = 0.08 * radius_mm
    section = section.offset(-rounding, circular_segments=BALL).offset(rounding, circular_segments=2 * BALL)
    body = Manifold.extrude(section.simplify(0.005), length_mm)
    half = np.linspace(0, np.pi / 2, CIRCLE // 4 + 1)
    dome = np.stack([radius_mm * np.cos(half), length_mm - 0.6 * radius_mm * (1 - np.sin(half))], axis=1)
    outline = np.concatenate([[[0.0, 0.0], [radius_mm, 0.0]], dome[:-1], [[0.0, length_mm]]])
    handle = body ^ Manifold.revolve(CrossSection([outline]), CIRCLE)
    return handle.translate((0, 0, -length_mm / 2)).rotate((-90, 0, 0))


def tube(centres_mm: Array, radii_mm: Array) -> Manifold:
    """Hulls of neighbouring balls along a polyline, united; centres of shape (points, 3) and radii (points,) [mm]."""
    balls = [
        Manifold.sphere(float(radius), BALL).translate(tuple(centre))
        for centre, radius in zip(centres_mm, radii_mm, strict=True)
    ]
    pieces = [Manifold.batch_hull([one, other]) for one, other in pairwise(balls)]
    return Manifold.batch_boolean(pieces, OpType.Add)


def scissor_loops(loop_width_mm: float, loop_length_mm: float, tube_radius_mm: float, gap_mm: float) -> Manifold:
    """The finger loops of scissors side by side in the xy plane, the arms together towards +y (`ScissorsObject`)."""
    turn = np.linspace(0, 2 * np.pi, 49)
    offset = (loop_width_mm + gap_mm) / 2 + tube_radius_mm
    loop = np.stack([loop_width_mm / 2 * np.cos(turn), loop_length_mm / 2 * np.sin(turn), 0 * turn], axis=1)
    parts = []
    for side in (-1.0, 1.0):
        centre = np.array([side * offset, 0.0, 0.0])
        end = centre + np.array([0.0, loop_length_mm / 2, 0.0])
        arm = np.stack([end, np.array([side * tube_radius_mm, loop_length_mm, 0.0])])
        parts += [tube(loop + centre, np.full(len(loop), tube_radius_mm)), tube(arm, np.full(len(arm), tube_radius_mm))]
    return Manifold.batch_boolean(parts, OpType.Add)


def banana_section(radius_mm: float, length_mm: float, bend_radius_mm: float) -> Manifold:
    """The middle of a banana along y: a bent five-sided bar with rounded ridges, its outer side towards +z.

    Its section is a quarter narrower at both ends than in the middle (`BananaObject`).
    """
    along = np.linspace(-1, 1, 13)
    angles = along * length_mm / 2 / bend_radius_mm
    sections = []
    for place, angle in zip(along, angles, strict=True):
        around = radius_mm * (1 - 0.25 * place**2)
        ridge = 0.4 * around
        ball = Manifold.sphere(ridge, BALL)
        spokes = np.radians(90 + 36 + 72 * np.arange(5))
        corners = [
            ball.translate(((around - ridge) * np.cos(spoke), 0.0, (around - ridge) * np.sin(spoke)))
            for spoke in spokes
        ]
        flat = Manifold.batch_hull(corners)
        lifted = flat.translate((0, 0, bend_radius_mm)).rotate((float(-np.degrees(angle)), 0, 0))
        sections.append(lifted.translate((0, 0, -bend_radius_mm)))
    pieces = [Manifold.batch_hull([one, other]) for one, other in pairwise(sections)]
    return Manifold.batch_boolean(pieces, OpType.Add)


@lru_cache(maxsize=8)
def _shape(build: Callable[..., Manifold], dimensions: tuple[float, ...], feature_mm: float) -> "MeshShape":
    """A solid as a shape; the last few are kept, because every frame asks for its own."""
    from magicsim.geometry.shapes.mesh_solid import MeshShape

    return MeshShape.of(from_manifold(build(*dimensions).simplify(1e-4)), feature_mm=feature_mm)


# Trees that outlive the interpreter are reported as leaks by libigl's binding
atexit.register(_shape.cache_clear)


class SpannerObject(ObjectBase):
    """The open end of a spanner, flat in its xy plane, the jaw towards +y, the head's centre at the origin."""

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

    def _solid(self) -> Shape:
        outline = (self.jaw_mm, self.head_radius_mm, self.handle_width_mm)
        return _shape(spanner_head, (*outline, self.thickness_mm, self.edge_radius_mm), self.thickness_mm / 2)

    def _problems(self) -> Iterator[str | None]:
        prong = self.head_radius_mm - self.jaw_mm / 2
        if prong <= 0:
            yield f"jaw_mm = {self.jaw_mm:g} is not allowed: must be below {2 * self.head_radius_mm:g}, the head's"
        yield edge_problem(self.edge_radius_mm, prong / 2, self.thickness_mm / 2, self.handle_width_mm / 2)


class ScrewdriverObject(ObjectBase):
    """The handle of a screwdriver along its y axis, with flutes and a domed butt at +y."""

    kind: Literal["screwdriver"]
    radius_mm: Size
    """Radius over the ridges [mm]."""
    length_mm: Size = 45.0
    """Length of the part that is modelled [mm]."""
    flutes: Annotated[int, Field(ge=3, le=12)] = 6
    """Number of grooves along the handle."""

    def _solid(self) -> Shape:
        return _shape(fluted_handle, (self.radius_mm, self.length_mm, self.flutes), 0.25 * self.radius_mm)

    def _problems(self) -> Iterator[str | None]:
        if self.length_mm <= self.radius_mm:
            yield f"length_mm = {self.length_mm:g} is not allowed: must be above radius_mm = {self.radius_mm:g}"


class ScissorsObject(ObjectBase):
    """The finger loops of scissors, side by side in the xy plane about the origin, the arms towards +y."""

    kind: Literal["scissors"]
    tube_radius_mm: Size
    """Radius of the loops' round stock [mm]."""
    loop_width_mm: Size = 20.0
    """Width of one loop's centre line, along x [mm]."""
    loop_length_mm: Size = 30.0
    """Length of one loop's centre line, along y [mm]."""
    gap_mm: Size = 2.0
    """Free distance between the loops [mm]."""

    def _solid(self) -> Shape:
        dimensions = (self.loop_width_mm, self.loop_length_mm, self.tube_radius_mm, self.gap_mm)
        return _shape(scissor_loops, dimensions, self.tube_radius_mm)


class BananaObject(ObjectBase):
    """The middle of a banana along its y axis: bent, five-sided, its outer side towards +z, about the origin."""

    kind: Literal["banana"]
    radius_mm: Size
    """Radius of the circle around the section [mm]."""
    length_mm: Size = 60.0
    """Length of the part that is modelled, along the bend [mm]."""
    bend_radius_mm: Annotated[float, Field(ge=20, le=1000)] = 120.0
    """Radius of the centre line [mm]."""

    def _solid(self) -> Shape:
        return _shape(banana_section, (self.radius_mm, self.length_mm, self.bend_radius_mm), 0.4 * self.radius_mm)

    def _problems(self) -> Iterator[str | None]:
        if self.radius_mm >= self.bend_radius_mm or self.length_mm > 2 * self.bend_radius_mm:
            yield (
                f"bend_radius_mm = {self.bend_radius_mm:g} is not allowed: must be above radius_mm = "
                f"{self.radius_mm:g} and at least half of length_mm = {self.length_mm:g}"
            )


LEAST_TOUCHING_MM = 0.5
"""Across which a mesh of unknown unit has to be to touch [mm]."""


class MeshObject(ObjectBase):
    """A watertight mesh from an STL, OBJ, PLY, OFF or GLB file, in the file's frame; that of a GLB file has y up."""

    kind: Literal["mesh"]
    path: FileName
    """The file; a relative path starts beside the TOML file that it stands in, or in the current folder."""
    scale: Annotated[float, Field(ge=1e-6, le=1e6)] | None = None
    """Millimetres per unit of the file; by default 1, and of a GLB file, which is in metres, 1000."""
    file_colors: bool = False
    """Whether the file's texture, vertices or faces (OBJ, PLY, GLB) give the colour instead of `color`; it is taken at
    the vertices of the drawn triangles."""
    feature_mm: Size | None = None
    """Smallest detail that contact resolves [mm]; half of the mesh's smallest extent by default."""

    def surface(self) -> SurfaceMesh:
        """See `ObjectBase.surface`, with the file's colours where asked for; `ConfigError` where it cannot press."""
        surface = self.shape().mesh()
        if not self.file_colors:
            return surface
        from magicsim.geometry.files.mesh_colors import file_colors
        from magicsim.geometry.files.mesh_file import mm_per_unit

        points = surface.vertices / mm_per_unit(self.path, self.scale)
        return replace(surface, colors=file_colors(self.path, points))

    def _solid(self) -> "MeshShape":
        from magicsim.geometry.files.mesh_file import load_mesh

        return load_mesh(self.path, scale=self.scale, feature_mm=self.feature_mm)

    def refuse_contact(self) -> None:
        """See `ObjectBase.refuse_contact`: a mesh that is tiny although nobody gave its scale is in metres."""
        if self.scale is None:
            low, high = self._solid().box_mm
            if (across := float((high - low).max())) < LEAST_TOUCHING_MM:
                raise ConfigError(
                    f"mesh '{self.path}' is {across:.4g} mm across and cannot touch: at least {LEAST_TOUCHING_MM:g} mm "
                    "are needed where no scale is given; metres? try scale=1000"
                )
