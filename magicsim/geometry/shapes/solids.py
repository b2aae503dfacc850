"""Rigid solids as signed distance, normal, support and mesh, each in the solid's own frame.

Distances are exact and positive outside; normals point outwards. All points are shape (count, 3) in mm.
"""

from dataclasses import dataclass
from typing import Protocol

import manifold3d
import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh, from_manifold

SEGMENTS = 128
"""Segments of a full circle in meshes: sag of 0.0003 radii."""
EDGE_SEGMENTS = 32
"""Segments of a full circle on the edges of boxes."""
TRIANGLE_MM = 0.6
"""Length to which the edges of meshes are split [mm]: triangles carry the irradiance of the object's surface."""
TINY = 1e-300


class Shape(Protocol):
    """A solid as contact and rendering know it."""

    def __hash__(self) -> int:
        """Solids are values, so that results for one may be kept."""

    @property
    def feature_mm(self) -> float:
        """Smallest length that contact has to resolve [mm]: of the part that presses, not of rounded edges.

        Contact points near the object lie at most about half of it apart, and the object moves at most about half of
        it in a load step. It is a radius or half width: of ball, shaft, dot, ridge or groove, flat end.
        """

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance, shape (count,) [mm], and outward unit normal, shape (count, 3)."""

    def support_mm(self, direction: Array) -> float:
        """Largest extent along a unit vector of shape (3,) [mm]."""

    def mesh(self) -> SurfaceMesh:
        """Closed triangle mesh whose vertices lie on the surface."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball about the origin."""

    radius_mm: float

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return self.radius_mm

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        length = np.linalg.norm(points, axis=1)
        return length - self.radius_mm, points / np.maximum(length, TINY)[:, None]

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return self.radius_mm * float(np.linalg.norm(direction))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        return from_manifold(manifold3d.Manifold.sphere(self.radius_mm, SEGMENTS))


@dataclass(frozen=True, slots=True)
class RoundedBox:
    """A cuboid about the origin, its edges rounded with a radius."""

    size_mm: tuple[float, float, float]
    edge_radius_mm: float

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return min(self.size_mm) / 2

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        distance, normal = rounded(np.abs(points) - self._core_mm)
        return distance - self.edge_radius_mm, normal * np.where(points < 0, -1.0, 1.0)

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        return float(np.abs(direction) @ self._core_mm + self.edge_radius_mm * np.linalg.norm(direction))

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        return from_manifold(self.solid(EDGE_SEGMENTS).refine_to_length(TRIANGLE_MM))

    def solid(self, segments: int) -> manifold3d.Manifold:
        """The hull of eight balls, with so many segments on a full circle of an edge."""
        ball = manifold3d.Manifold.sphere(self.edge_radius_mm, segments)
        signs = np.array(list(np.ndindex(2, 2, 2))) * 2.0 - 1
        corners = [ball.translate(tuple(self._core_mm * sign)) for sign in signs]
        return manifold3d.Manifold.batch_hull(corners)

    @property
    def _core_mm(self) -> Array:
        """Half edges of the cuboid that the edges are rounded about, shape (3,) [mm]."""
        return np.array(self.size_mm) / 2 - self.edge_radius_mm


@dataclass(frozen=True, slots=True)
class RoundedCylinder:
    """A cylinder about the origin along one axis, its rims rounded with a radius."""

    radius_mm: float
    length_mm: float
    axis: str
    edge_radius_mm: float

    @property
    def feature_mm(self) -> float:
        """See `Shape.feature_mm`."""
        return min(self.radius_mm, self.length_mm / 2)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """See `Shape.distance`."""
        along, across = self._split(points)
        radial, outward = around_axis(across)
        core_radius, core_half = self._core_mm
        offset = np.stack([radial - core_radius, np.abs(along) - core_half], axis=1)
        distance, profile_normal = rounded(offset)
        normal = np.empty_like(points)
        axis = "xyz".index(self.axis)
        others = [other for other in range(3) if other != axis]
        normal[:, axis] = profile_normal[:, 1] * np.where(along < 0, -1.0, 1.0)
        normal[:, others] = profile_normal[:, :1] * outward
        return distance - self.edge_radius_mm, normal

    def support_mm(self, direction: Array) -> float:
        """See `Shape.support_mm`."""
        along, across = self._split(direction[None])
        core_radius, core_half = self._core_mm
        rounded = self.edge_radius_mm * np.linalg.norm(direction)
        return float(core_half * abs(along[0]) + core_radius * np.linalg.norm(across) + rounded)

    def mesh(self) -> SurfaceMesh:
        """See `Shape.mesh`."""
        return from_manifold(self.manifold().refine_to_length(TRIANGLE_MM))

    def manifold(self) -> manifold3d.Manifold:
        """The solid of revolution, its triangles as long as they come."""
        edge = self.edge_radius_mm
        angles = np.linspace(0, np.pi / 2, 9)
        core_radius, core_half = self._core_mm
        upper = np.stack([core_radius + edge * np.cos(angles), core_half + edge * np.sin(angles)], axis=1)
        lower = (upper * [1, -1])[::-1]
        profile = np.concatenate([[[0.0, -self.length_mm / 2]], lower, upper, [[0.0, self.length_mm / 2]]])
        solid = manifold3d.Manifold.revolve(manifold3d.CrossSection([profile]), SEGMENTS)
        turn = {"x": (0.0, 90.0, 0.0), "y": (-90.0, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}[self.axis]
        return solid.rotate(turn)

    @property
    def _core_mm(self) -> tuple[float, float]:
        """Radius and half length of the cylinder that the rims are rounded about [mm]."""
        return self.radius_mm - self.edge_radius_mm, self.length_mm / 2 - self.edge_radius_mm

    def _split(self, points: Array) -> tuple[Array, Array]:
        axis = "xyz".index(self.axis)
        return points[:, axis], np.delete(points, axis, axis=1)


def rounded(offset: Array) -> tuple[Array, Array]:
    """Distance and gradient of the positive orthant's corner, from per-axis offsets, shape (count, axes)."""
    outside = np.maximum(offset, 0)
    length = np.linalg.norm(outside, axis=1)
    is_outside = length > 0
    nearest = np.zeros_like(offset)
    nearest[np.arange(len(offset)), np.argmax(offset, axis=1)] = 1.0
    normal = np.where(is_outside[:, None], outside / np.maximum(length, TINY)[:, None], nearest)
    return np.where(is_outside, length, offset.max(axis=1)), normal


def around_axis(across: Array) -> tuple[Array, Array]:
    """Distance from an axis, shape (count,), and unit direction away from it, shape (count, 2); along x on the axis."""
    radial = np.linalg.norm(across, axis=1)
    outward = across / np.maximum(radial, TINY)[:, None]
    outward[radial < TINY] = (1.0, 0.0)
    return radial, outward
