"""Plates that press with bumps on their upper face, hemispheres or ridges: what a user writes for them, and the shape.

A plate is a rounded box; every bump stands on the flat part of its upper face. Outside, the distance to the union is
the smaller of the distances to plate and nearest bump. Inside, the face below a bump is no surface: there the nearest
surface of the upper side is the bump's outline on the face.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold
from magicsim.geometry.objects.rigid_object import EDGE_RADIUS_MM, SHELL_MM, SHELL_SHARE, ObjectBase, Size
from magicsim.geometry.shapes.solids import EDGE_SEGMENTS, TINY, TRIANGLE_MM, RoundedBox, Shape, around_axis, rounded

CELLS_A_PERIOD = 4
"""Lattice cells along one spacing that resolve a pattern. Of one of 2 mm, 3 bring a quarter of what 8 do through a skin
of 0.8 mm, 4 four fifths (`benchmarks/texture_resolution.py`)."""
MAX_DOTS = 2500
"""More would not fit in memory as meshes that are round enough."""
MAX_RIDGES = 200
RIDGE_EDGE_SHARE = 0.25
"""Radius of a ridge's edges in units of its width, where none is given."""
DOT_TRIANGLES = 45_000
"""Triangles that all dots of a plate share."""
RIDGE_SEGMENTS = 16
"""Segments of a full circle on the edges of a ridge."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plate:
    """A square plate with rounded edges, in coordinates whose z = 0 is its upper face."""

    size_mm: float
    """Side [mm]."""
    thickness_mm: float
    """From face to face [mm]."""
    edge_radius_mm: float
    """Radius of all edges [mm]."""

    @property
    def flat_mm(self) -> float:
        """Side of the flat part of the upper face [mm]."""
        return self.size_mm - 2 * self.edge_radius_mm

    @property
    def box(self) -> RoundedBox:
        """The plate about its own middle."""
        return RoundedBox((self.size_mm, self.size_mm, self.thickness_mm), self.edge_radius_mm)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        return self.box.distance(points + np.array([0, 0, self.thickness_mm / 2]))

    def below_bump(self, points: Array, inset: Array, outward: Array) -> tuple[Array, Array]:
        """Signed distance and normal of points inside the plate that lie `inset` [mm] within a bump's outline.

        The nearest point of the outline is in the direction `outward`, shape (count, 2).
        """
        # The plate without its upper face, then the outline
        height = self.thickness_mm + 4 * self.size_mm
        tall = RoundedBox((self.size_mm, self.size_mm, height), self.edge_radius_mm)
        distance, normal = tall.distance(points + np.array([0, 0, self.thickness_mm - height / 2]))
        outline = np.hypot(inset, points[:, 2])
        to_outline = np.concatenate([inset[:, None] * outward, -points[:, 2:]], axis=1)
        nearer = outline < -distance
        distance[nearer] = -outline[nearer]
        normal[nearer] = to_outline[nearer] / np.maximum(outline[nearer], TINY)[:, None]
        return distance, normal


@dataclass(frozen=True, slots=True, kw_only=True)
class DotPlate:
    """Hemispheres in a square array on a plate, centred on the origin; exact distances inside and outside."""

    radius_mm: float
    """Radius of each hemisphere [mm]."""
    spacing_mm: float
    """Between neighbouring centres [mm], above two radii."""
    plate: Plate

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return self.radius_mm

    @property
    def count(self) -> int:
        """Dots along one side."""
        return places_on(self.plate.flat_mm - 2 * self.radius_mm, self.spacing_mm)

    @property
    def face_mm(self) -> float:
        """Height of the plate's upper face [mm]."""
        return (self.plate.thickness_mm - self.radius_mm) / 2

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        local = points - np.array([0, 0, self.face_mm])
        distance, normal = self.plate.distance(local)
        offset = local.copy()
        offset[:, :2] -= nearest_place(local[:, :2], self.count, self.spacing_mm)
        length = np.linalg.norm(offset, axis=1)
        on_dot = np.flatnonzero((local[:, 2] >= 0) & (length - self.radius_mm < distance))
        below = (local[:, 2] < 0) & (distance < 0)
        radial, outward = around_axis(offset[:, :2])
        below &= radial < self.radius_mm
        distance[on_dot] = length[on_dot] - self.radius_mm
        normal[on_dot] = offset[on_dot] / np.maximum(length[on_dot], TINY)[:, None]
        normal[on_dot[length[on_dot] < TINY]] = (0, 0, 1)
        distance[below], normal[below] = self.plate.below_bump(
            local[below], self.radius_mm - radial[below], outward[below]
        )
        return distance, normal

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        reach = (self.count - 1) / 2 * self.spacing_mm * float(np.abs(direction[:2]).sum())
        ball = self.radius_mm * float(np.hypot(np.hypot(direction[0], direction[1]), max(0.0, direction[2])))
        box = self.plate.box.support_mm(direction) - self.plate.thickness_mm / 2 * direction[2]
        return self.face_mm * float(direction[2]) + max(reach + ball, float(box))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        segments = int(np.clip(4 * (np.sqrt(DOT_TRIANGLES / self.count**2) // 2), 8, 32))
        # The ball reaches into the plate, never through it: solids that only touch would keep their faces
        rooted = min(self.radius_mm, self.plate.thickness_mm) / 2
        dot = manifold3d.Manifold.sphere(self.radius_mm, segments).trim_by_plane((0, 0, 1), -rooted)
        places = (np.arange(self.count) - (self.count - 1) / 2) * self.spacing_mm
        return _assemble(self.plate, self.face_mm, [dot.translate((x, y, 0)) for x in places for y in places])


@dataclass(frozen=True, slots=True, kw_only=True)
class RidgePlate:
    """Parallel ridges along y on a plate, centred on the origin; exact distances inside and outside."""

    width_mm: float
    """Width of each ridge [mm]."""
    spacing_mm: float
    """Period [mm], above the width."""
    height_mm: float
    """Height of the ridges above the face, the depth of the grooves [mm]."""
    edge_radius_mm: float
    """Radius of the edges of the ridges [mm], at most half of the width."""
    plate: Plate

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return min(self.width_mm, self.spacing_mm - self.width_mm) / 2

    @property
    def count(self) -> int:
        """Ridges on the plate."""
        return places_on(self.plate.flat_mm - self.width_mm, self.spacing_mm)

    @property
    def face_mm(self) -> float:
        """Height of the plate's upper face [mm]."""
        return (self.plate.thickness_mm - self.height_mm) / 2

    @property
    def ridge(self) -> RoundedBox:
        """One ridge about its middle, from the plate's lower face to the top."""
        height = self.plate.thickness_mm + self.height_mm
        return RoundedBox((self.width_mm, self.plate.flat_mm, height), self.edge_radius_mm)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        local = points - np.array([0, 0, self.face_mm])
        distance, normal = self.plate.distance(local)
        offset = points.copy()
        offset[:, :1] -= nearest_place(points[:, :1], self.count, self.spacing_mm)
        ridge_distance, ridge_normal = self.ridge.distance(offset)
        on_ridge = (local[:, 2] >= 0) & (ridge_distance < distance)
        below = (local[:, 2] < 0) & (distance < 0)
        core = np.array(self.ridge.size_mm)[:2] / 2 - self.edge_radius_mm
        inset, outward = rounded(np.abs(offset[:, :2]) - core)
        inset = self.edge_radius_mm - inset
        outward = outward * np.where(offset[:, :2] < 0, -1.0, 1.0)
        below &= inset > 0
        distance[on_ridge], normal[on_ridge] = ridge_distance[on_ridge], ridge_normal[on_ridge]
        distance[below], normal[below] = self.plate.below_bump(local[below], inset[below], outward[below])
        return distance, normal

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        reach = (self.count - 1) / 2 * self.spacing_mm * abs(float(direction[0]))
        box = self.plate.box.support_mm(direction) + (self.face_mm - self.plate.thickness_mm / 2) * direction[2]
        return max(reach + self.ridge.support_mm(direction), float(box))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        ridge = self.ridge.solid(RIDGE_SEGMENTS)
        places = (np.arange(self.count) - (self.count - 1) / 2) * self.spacing_mm
        return _assemble(self.plate, self.face_mm, [ridge.translate((x, 0, -self.face_mm)) for x in places])


def places_on(length_mm: float, spacing_mm: float) -> int:
    """How many points of a spacing fit on a length, both ends included."""
    return int(np.floor(length_mm / spacing_mm + 1e-9)) + 1 if length_mm >= 0 else 0


def nearest_place(coordinates: Array, count: int, spacing_mm: float) -> Array:
    """Nearest point of a centred row of `count`, per coordinate, the shape kept [mm]."""
    half = (count - 1) / 2
    return np.asarray((np.clip(np.round(coordinates / spacing_mm + half), 0, count - 1) - half) * spacing_mm)


def _assemble(plate: Plate, face_mm: float, bumps: list[manifold3d.Manifold]) -> SurfaceMesh:
    """Union of a plate and its bumps, which are placed in the plate's coordinates."""
    parts = [plate.box.solid(EDGE_SEGMENTS).translate((0, 0, -plate.thickness_mm / 2)), *bumps]
    union = manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add)
    return from_manifold(union.translate((0, 0, face_mm)).refine_to_length(TRIANGLE_MM))


class PlateObject(ObjectBase):
    """A square plate with something on it."""

    size_mm: Size = 6.0
    """Side of the square plate [mm]."""
    thickness_mm: Size = 2.0
    """Thickness of the plate without its texture [mm]."""

    def plate(self) -> Plate:
        """The plate below the texture; edges of 0.1 mm, or of a quarter of a thinner plate."""
        edge = min(EDGE_RADIUS_MM, self.thickness_mm / 4, self.size_mm / 4)
        return Plate(size_mm=self.size_mm, thickness_mm=self.thickness_mm, edge_radius_mm=edge)

    def _misfits(self, what: str, needed_mm: float, along: int, most: int, total: int) -> Iterator[str]:
        """One texture element must fit on the flat part, and all of them in memory."""
        if along == 0:
            yield (
                f"size_mm = {self.size_mm:g} is not allowed: one {what} needs {needed_mm:g} mm of the "
                f"{self.plate().flat_mm:.4g} mm that are flat"
            )
        if total > most:
            yield f"{total} {what}s are too many: at most {most}; use a larger spacing_mm or a smaller size_mm"


class DotsObject(PlateObject):
    """Hemispheres in a square array, as many as fit on the plate."""

    kind: Literal["dots"]
    radius_mm: Size
    """Radius of each hemisphere [mm]."""
    spacing_mm: Size
    """Between neighbouring centres [mm]."""

    def _problems(self) -> Iterator[str | None]:
        if self.spacing_mm <= 2 * self.radius_mm:
            yield f"spacing_mm = {self.spacing_mm:g} is not allowed: must be above 2 radius_mm = {2 * self.radius_mm:g}"
        along = self._solid().count
        yield from self._misfits("dot", 2 * self.radius_mm, along, MAX_DOTS, along**2)

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

    def _problems(self) -> Iterator[str | None]:
        if self.spacing_mm <= self.width_mm:
            yield f"spacing_mm = {self.spacing_mm:g} is not allowed: must be above width_mm = {self.width_mm:g}"
        most = min(self.width_mm, self.height_mm or self.width_mm) / 2
        if self.edge_radius_mm is not None and self.edge_radius_mm > most:
            yield f"edge_radius_mm = {self.edge_radius_mm:g} is not allowed: must be at most {most:g} mm"
        along = self._solid().count
        yield from self._misfits("ridge", self.width_mm, along, MAX_RIDGES, along)

    def _solid(self) -> RidgePlate:
        height = self.height_mm or self.width_mm
        edge = self.edge_radius_mm or RIDGE_EDGE_SHARE * min(self.width_mm, height)
        return RidgePlate(
            width_mm=self.width_mm, spacing_mm=self.spacing_mm, height_mm=height, edge_radius_mm=edge,
            plate=self.plate(),
        )  # fmt: skip
