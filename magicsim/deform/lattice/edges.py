"""Where an object's edges press on the face, and how close node planes lie there.

Below the rim of a flat punch pressure has a peak that is much narrower than a printed cell. On cells of that size the
rim is felt as a larger one, and the face waves between its nodes: force and area are off the more the wider a cell is.
An edge is a place where the solid's surface turns within a fraction of a cell, with room behind it: tips, ridges and
tubes narrower than a cell are none, since what presses there is as small as they are.

Across an edge planes are as close as its radius, and spread with the distance from it. An edge that runs along an axis
asks nothing of the planes across that axis: what counts is the spacing along the edge's horizontal normal.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from magicsim.arrays import Array, Index, Mask
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.mesh import SurfaceMesh

SHARP_SHARE = 0.7
"""Radius below which a surface turns sharply, in units of the cell's pitch: assumed."""
CREASE_RAD, FLAT_RAD = 0.5, 1e-3
"""Angle between two triangles from which their common side is an edge, however large they are, and up to which it is
none, however small: assumed."""
ROOM_SHARE = 1.5
"""Way from an edge to the opposite one behind it, in units of the pitch, below which both bound something narrow:
assumed."""
OPPOSITE = -0.5
"""Cosine between the outward directions of two edges below which they face away from each other: assumed."""
FACING, UPRIGHT = 0.2, 0.98
"""Least and largest cosine between an edge's normal and the way of the press: walls, and crests that have no side;
assumed."""
FINEST_EDGE_MM, FINE_SHARE = 0.1, 0.05
"""Planes are never closer than this across an edge [mm], nor than this part of the half width of what touches: the
force of a flat face is off by about a third of the spacing at its edge over its half width."""
DEEP_SHARE = 0.08
"""Nor than this part of the depth of the press: finer cells beside a sharp edge fold where it is pressed deep."""
SPREAD = 0.6
"""Increase of the spacing per distance from the edge: assumed."""
DEPTH_SHARE = 3.0
"""Spacing along z at the face in units of that across the sharpest edge: forces hardly depend on it."""
SAMPLE_MM = 0.25
"""Spacing of samples along an edge [mm]: assumed."""
PART_SLACK = 0.1
"""Part of a spacing by which an interval may be longer than a whole number of them: assumed."""
DIGITS, ROUNDING_MM = 9, 1e-9
"""Digits of what is rounded up, and slack of what is compared [mm], so that rounding does not decide."""
STEPS = 64
"""Places in an interval at which the spacing is asked for."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Edges:
    """Samples of edges along the path of an object."""

    low_mm: Array
    """Smallest x and y of each sample on its way, shape (samples, 2) [mm]."""
    high_mm: Array
    """Largest x and y, shape (samples, 2) [mm]."""
    across: Array
    """Share of the edge's horizontal normal along x and y, shape (samples, 2)."""
    radius_mm: Array
    """Radius of each edge, or what is fine enough for it, shape (samples,) [mm]."""

    def split(self, planes_mm: Array, axis: int, *, scale: float) -> Array:
        """Planes along x (0) or y (1) [mm], and more of them near the edges, by spacings times a scale."""
        wanted = scale * self.radius_mm / np.maximum(self.across[:, axis], 1e-9)
        relevant = wanted < np.diff(planes_mm).max()
        low, high, wanted = self.low_mm[relevant, axis], self.high_mm[relevant, axis], wanted[relevant]

        def spacing(places: Array) -> Array:
            away = np.maximum(np.maximum(low - places[:, None], places[:, None] - high), 0.0)
            return np.asarray((wanted + SPREAD * away).min(axis=1, initial=np.inf))

        return _split(planes_mm, spacing)

    def split_depth(self, planes_mm: Array, *, scale: float) -> Array:
        """Planes along z from the face on [mm] with more of them near it; `scale` is that of `split`."""
        least = DEPTH_SHARE * scale * float(self.radius_mm.min())
        return _split(planes_mm, lambda places: least + SPREAD * places)


def pressed_edges(
    indenters: Sequence[Indenter], *, pitch_mm: float, half_face_mm: tuple[float, float], half_width_mm: float
) -> Edges | None:
    """The edges of an object that can press on the face, from the poses that bound its path; None where there are none.

    Without edges nodes are a pitch apart [mm]; the width is the shorter side of what is touched [mm].
    """
    touching = [indenter for indenter in indenters if indenter.top_mm() > 0]
    if not touching:
        return None
    own, normals, radius = _sharp_edges(touching[0].shape.mesh(), SHARP_SHARE * pitch_mm)
    poses = [(indenter.pose.to_sensor(own), normals @ indenter.pose.rotation.T) for indenter in touching]
    reaches = np.any([_reaches(places, outward, half_face_mm) for places, outward in poses], axis=0)
    reaches &= np.any([_has_room(places, outward, reaches, ROOM_SHARE * pitch_mm) for places, outward in poses], axis=0)
    if not reaches.any():
        return None
    depth = max(indenter.top_mm() for indenter in touching)
    least = max(FINEST_EDGE_MM, FINE_SHARE * half_width_mm, DEEP_SHARE * depth)
    legs = list(pairwise(poses)) or [(poses[0], poses[0])]
    low = [np.minimum(first[0], last[0])[reaches, :2] for first, last in legs]
    high = [np.maximum(first[0], last[0])[reaches, :2] for first, last in legs]
    across = [np.maximum(_horizontal(first[1]), _horizontal(last[1]))[reaches] for first, last in legs]
    return Edges(
        low_mm=np.concatenate(low),
        high_mm=np.concatenate(high),
        across=np.concatenate(across),
        radius_mm=np.tile(np.maximum(radius[reaches], least), len(legs)),
    )


def triangle_normals(mesh: SurfaceMesh) -> tuple[Array, Array]:
    """Outward normals of a mesh's triangles, shape (triangles, 3), and twice their areas [mm2]."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(normal, axis=1)
    return normal / np.maximum(twice_area, 1e-30)[:, None], twice_area


def paired_sides(mesh: SurfaceMesh) -> tuple[Array, Array, Index, Index]:
    """Sides of a closed mesh's triangles: where they start and end, shapes (sides, 3) [mm], and both triangles."""
    sides = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]).astype(np.int64)
    order = np.lexsort((sides[:, 0], sides.max(1), sides.min(1)))[: len(sides) // 2 * 2]
    start, end = mesh.vertices[sides[order[::2]]].transpose(1, 0, 2)
    return start, end, order[::2] % len(mesh.faces), order[1::2] % len(mesh.faces)


def _sharp_edges(mesh: SurfaceMesh, largest_radius_mm: float) -> tuple[Array, Array, Array]:
    """Convex sides of triangles across which a closed surface turns sharply: with a radius below the largest one [mm].

    Samples along them: places [mm] and means of both normals, shapes (samples, 3), and radii, shape (samples,) [mm].
    """
    normal, twice_area = triangle_normals(mesh)
    start, end, one, other = paired_sides(mesh)
    length = np.maximum(np.linalg.norm(end - start, axis=1), 1e-30)
    turn = np.arccos(np.clip(np.einsum("ei,ei->e", normal[one], normal[other]), -1, 1))
    between = (twice_area[one] + twice_area[other]) / (3 * length)
    is_convex = np.einsum("ei,ei->e", np.cross(normal[one], normal[other]), end - start) > 0
    is_sharp = (turn > CREASE_RAD) | (turn * largest_radius_mm > between)
    chosen = np.flatnonzero(is_convex & is_sharp & (turn > FLAT_RAD))
    radius = np.where(turn > CREASE_RAD, 0.0, between / np.maximum(turn, 1e-9))[chosen]
    parts = np.maximum(1, np.ceil(np.round(length[chosen] / SAMPLE_MM, DIGITS)).astype(int))
    which = np.repeat(np.arange(len(chosen)), parts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = ((number + 0.5) / parts[which])[:, None]
    middle = normal[one] + normal[other]
    middle /= np.maximum(np.linalg.norm(middle, axis=1), 1e-30)[:, None]
    places = start[chosen][which] * (1 - share) + end[chosen][which] * share
    return places, middle[chosen][which], radius[which]


def _reaches(places: Array, outward: Array, half_face_mm: tuple[float, float]) -> Mask:
    """Which samples lie above the undeformed face, inside its sides, and face the block, shape (samples,)."""
    is_within = (np.abs(places[:, :2]) < np.array(half_face_mm)).all(axis=1)
    return np.asarray(is_within & (places[:, 2] > 0) & (outward[:, 2] > FACING) & (outward[:, 2] < UPRIGHT))


def _has_room(places: Array, outward: Array, chosen: Mask, room_mm: float) -> Mask:
    """Which samples have no edge of the opposite side near behind them, nor one beside them that has, (samples,)."""
    has_room = np.zeros(len(places), bool)
    own = np.flatnonzero(chosen)
    if len(own) == 0:
        return has_room
    flat, away = places[own, :2], outward[own, :2]
    away = away / np.maximum(np.linalg.norm(away, axis=1), 1e-9)[:, None]
    # samples of about the same place and direction meet others as their mean, which has the same one in a mirror
    cells = np.round(np.round(np.concatenate([flat / (SAMPLE_MM / 2), 2 * away], 1), DIGITS)) + 0.0
    _, group, size = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    flat, away = (
        np.stack([np.bincount(group, column) / size for column in values.T], axis=1) for values in (flat, away)
    )
    tree = cKDTree(flat)
    is_free = np.ones(len(flat), bool)
    for number, near in enumerate(tree.query_ball_point(flat, room_mm + ROUNDING_MM)):
        is_opposite = away[near] @ away[number] < OPPOSITE
        is_behind = (flat[near] - flat[number]) @ away[number] < -ROUNDING_MM
        is_free[number] = not (is_opposite & is_behind).any()
    beside = tree.query_ball_point(flat, room_mm / 2 + ROUNDING_MM)
    has_room[own] = np.array([is_free[near].all() for near in beside])[group]
    return has_room


def _horizontal(outward: Array) -> Array:
    """Shares of the horizontal part of normals along x and y, shape (samples, 2)."""
    flat = np.abs(outward[:, :2])
    return np.asarray(flat / np.maximum(np.linalg.norm(flat, axis=1), 1e-9)[:, None])


def _split(planes_mm: Array, spacing: Callable[[Array], Array]) -> Array:
    """Planes with every interval divided so that the parts follow a spacing."""
    parts = [planes_mm[:1]]
    for low, high in pairwise(planes_mm.tolist()):
        places = np.linspace(low, high, STEPS + 1)
        density = 1 / np.minimum(spacing(places), high - low)
        passed = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)]) * (high - low) / STEPS
        count = max(1, int(np.ceil(round(passed[-1] - PART_SLACK, DIGITS))))
        parts.append(np.interp(np.arange(1, count) / count * passed[-1], passed, places))
        parts.append(np.array([high]))
    return np.concatenate(parts)
