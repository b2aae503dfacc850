"""Quadrature points of the contact face: where contact is tested, and how they follow the lattice's nodes.

The face at rest is divided into facets, the rectangles of the lattice's plane z = 0. Points a facet: a regular
grid of midpoints with equal weights, their number along an edge odd so that the centre is one of them and at least
`MIN_POINTS`; where contact is expected they are close enough to find every feature of the object, as far as
`MAX_POINTS` allow: textures much finer than the lattice want a finer `lattice.spacing_mm`.

Between nodes the displacement is interpolated by cubics through the four nearest planes of each direction, not
bilinearly: a flat facet cuts into an object of curvature 1/R by spacing^2 / 8 R (0.03 mm at 1 mm and R = 4 mm), so
pointwise contact on flat facets would press at their middles only, 10 % too stiff and with a tenth of the contact
area. Where the four planes are irregular one polynomial would overshoot, with weights up to 4 beside printed walls, and
contact would not settle; there each plane gets the slope of the chord between its neighbours. Forces go to the nodes
with the same weights, so force and torque of the points are those of the nodes.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.structure import Lattice, located
from magicsim.geometry.shapes.solids import Shape
from magicsim.kernels import kernel

POINT_SPACING_MM = 0.35
"""Largest distance between neighbouring contact points at rest: assumed."""
MIN_POINTS = 3
"""Fewest points along a facet's edge."""
MAX_POINTS = 5
"""Most points along a facet's edge: a facet cannot follow more, and contact that it cannot follow does not converge."""
FINEST_SPACING_MM = 0.05
"""Contact points are never closer: assumed."""
STENCIL = 4
"""Planes that one coordinate is interpolated from."""
ROUNDING = 1e-9
"""Slack of lengths [mm] and of a whole number of spacings."""
IRREGULAR = 2.0 - ROUNDING
"""Ratio of spacings from which one cubic through four planes would overshoot: assumed."""


def point_spacing_mm(shape: Shape) -> float:
    """Distance of contact points that finds every feature of an object: half of the smallest one [mm]."""
    return min(POINT_SPACING_MM, max(shape.feature_mm / 2, FINEST_SPACING_MM))


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactFace:
    """Quadrature points, ordered by facet."""

    patches: Index
    """Nodes that move the points of each facet, ascending, shape (facets, nodes a patch)."""
    facet: Index
    """Facet of each point, shape (points,)."""
    shape: Array
    """Weight of each patch node at each point, shape (points, nodes a patch)."""
    slopes: Array
    """Derivatives of the weights along x and y at rest, shape (points, nodes a patch, 2) [1/mm]."""
    area_mm2: Array
    """Rest area of each point, shape (points,) [mm2]."""

    def positions(self, nodes: Array) -> Array:
        """Points from node positions, shape (points, 3) [mm]."""
        return np.asarray(gather(self.shape, self.facet, self.patches, nodes))

    def current_area_mm2(self, nodes: Array, points: Index | slice = slice(None)) -> Array:
        """Deformed area of some points, of all by default, shape (points,) [mm2]."""
        tangents = np.einsum("qad,qai->dqi", self.slopes[points], nodes[self.patches[self.facet[points]]])
        return np.asarray(self.area_mm2[points] * np.linalg.norm(np.cross(tangents[0], tangents[1]), axis=1))


def contact_face(lattice: Lattice, *, point_spacing_mm: float = POINT_SPACING_MM) -> ContactFace:
    """The quadrature points of a lattice's contact face.

    They are at most so far apart where contact is expected [mm], and as coarse as `MIN_POINTS` allows beyond.
    """
    along_x, along_y, facet = _axes(lattice, point_spacing_mm)
    order = np.argsort(facet, kind="stable")
    nx, ny = (len(planes) for planes in lattice.planes_mm[:2])
    patches = _stencils(ny)[:, None, :, None] * nx + _stencils(nx)[None, :, None, :]
    face = ContactFace(
        patches=patches.reshape((nx - 1) * (ny - 1), -1),
        facet=facet[order],
        shape=_product(along_y.shape, along_x.shape)[order],
        slopes=np.stack([_product(along_y.shape, along_x.slope), _product(along_y.slope, along_x.shape)], -1)[order],
        area_mm2=np.outer(along_y.width_mm, along_x.width_mm).ravel()[order],
    )
    if lattice.face is None:
        return face
    # The points of a curved face have their own rest areas; one of both slopes is per length along the face.
    area, slopes = face.current_area_mm2(lattice.nodes_mm), face.slopes.copy()
    slopes[..., 0] *= (face.area_mm2 / area)[:, None]
    return replace(face, area_mm2=area, slopes=slopes)


def point_boxes_mm(lattice: Lattice, *, point_spacing_mm: float = POINT_SPACING_MM) -> tuple[Array, Array]:
    """Smallest and largest x and y of the rectangles that contact points stand for, each of shape (points, 2) [mm].

    Points have the order of `contact_face`; rectangles tile the face, of a curved one its projection along z.
    """
    along_x, along_y, facet = _axes(lattice, point_spacing_mm)
    order = np.argsort(facet, kind="stable")

    def on_plane(y: Array, x: Array) -> Array:
        return np.stack([np.tile(x, len(y)), np.repeat(y, len(x))], 1)[order]

    low = on_plane(along_y.low_mm, along_x.low_mm)
    return low, low + on_plane(along_y.width_mm, along_x.width_mm)


def _axes(lattice: Lattice, spacing_mm: float) -> "tuple[_Axis, _Axis, Index]":
    """Points along x and y, and the facet of each of their crossings, x fastest, shape (points,)."""
    zone = lattice.zone
    along_x, along_y = (
        _along(planes, spacing_mm, (zone.low_mm[axis], zone.high_mm[axis]) if zone else None)
        for axis, planes in enumerate(lattice.planes_mm[:2])
    )
    facet = along_y.interval[:, None] * (len(lattice.planes_mm[0]) - 1) + along_x.interval[None, :]
    return along_x, along_y, np.asarray(facet.ravel())


class _Axis(NamedTuple):
    """Points along one axis of the face: their intervals, weights and derivatives of these, shape (points, stencil)."""

    interval: Index
    shape: Array
    slope: Array
    low_mm: Array
    """Where the length begins that each point stands for, shape (points,) [mm]."""
    width_mm: Array


def _along(planes: Array, spacing_mm: float, zone: tuple[float, float] | None) -> _Axis:
    """Points in each interval: an odd number, at most a spacing apart inside the zone."""
    width = np.diff(planes)
    counts: Index = np.clip(np.ceil(width / spacing_mm - ROUNDING).astype(np.int64) | 1, MIN_POINTS, MAX_POINTS)
    if zone is not None:
        counts[(planes[1:] < zone[0] - ROUNDING) | (planes[:-1] > zone[1] + ROUNDING)] = MIN_POINTS
    interval = np.repeat(np.arange(len(width)), counts)
    number = np.arange(len(interval)) - np.repeat(np.cumsum(counts) - counts, counts)
    shape, slope = _weights(planes, interval, (number + 0.5) / counts[interval])
    share = (width / counts)[interval]
    return _Axis(interval, shape, slope, planes[interval] + number * share, share)


def face_weights(lattice: Lattice, points_mm: Array) -> sp.csr_matrix:
    """Weights of the nodes at any points of the face at rest, as the contact points have them, shape (points, nodes).

    Places are those at rest, shape (points, 2) [mm]; outside, the nearest place in the face.
    """
    columns, shapes = [], []
    for planes, place in zip(lattice.planes_mm[:2], points_mm.T, strict=True):
        interval, t = located(planes, place)
        shape = _weights(planes, interval, t)[0]
        columns.append(_stencils(len(planes))[interval])
        shapes.append(shape)
    nodes = (columns[1][:, :, None] * len(lattice.planes_mm[0]) + columns[0][:, None, :]).reshape(len(points_mm), -1)
    weights = (shapes[1][:, :, None] * shapes[0][:, None, :]).reshape(nodes.shape)
    rows = np.arange(0, nodes.size + 1, nodes.shape[1])
    return sp.csr_matrix((weights.ravel(), nodes.ravel(), rows), shape=(len(points_mm), len(lattice.nodes_mm)))


def axis_weights(planes_mm: Array, places_mm: Array) -> tuple[Array, Array]:
    """Weights of all node planes of one axis at places between them, as the contact points have them.

    Places lie from the first plane to the last; weights and their derivatives [1/mm] are of shape (places, planes).
    """
    interval, t = located(planes_mm, places_mm)
    stencil = _stencils(len(planes_mm))[interval]
    weights, slopes = np.zeros((2, len(places_mm), len(planes_mm)))
    for dense, part in zip((weights, slopes), _weights(planes_mm, interval, t), strict=True):
        np.put_along_axis(dense, stencil, part, axis=1)
    return weights, slopes


def _stencils(planes: int) -> Index:
    """Planes that each interval is interpolated from, shape (planes - 1, stencil)."""
    size = min(STENCIL, planes)
    return np.clip(np.arange(planes - 1) - (size // 2 - 1), 0, planes - size)[:, None] + np.arange(size)


def _weights(planes: Array, interval: Index, t: Array) -> tuple[Array, Array]:
    """Weights of the stencil at places t in [0, 1] of intervals, and their derivatives, shapes (points, stencil)."""
    stencil = _stencils(len(planes))[interval]
    cubic = _lagrange(planes[stencil], planes[interval] + np.diff(planes)[interval] * t)
    smooth = [np.take_along_axis(weights, stencil, axis=1) for weights in _hermite(planes, interval, t)]
    spacings = np.diff(planes[stencil], axis=1)
    is_regular = spacings.max(1, keepdims=True) < IRREGULAR * spacings.min(1, keepdims=True)
    shape, slope = (np.where(is_regular, one, other) for one, other in zip(cubic, smooth, strict=True))
    return shape, slope


def _lagrange(nodes: Array, points: Array) -> tuple[Array, Array]:
    """Weights of each point's own nodes, shape (points, nodes), and their derivatives: one polynomial through all."""
    shape, slope = np.ones_like(nodes), np.zeros_like(nodes)
    size = nodes.shape[1]
    for a in range(size):
        for b in range(size):
            if a == b:
                continue
            run = nodes[:, a] - nodes[:, b]
            slope[:, a] = slope[:, a] * (points - nodes[:, b]) / run + shape[:, a] / run
            shape[:, a] *= (points - nodes[:, b]) / run
    return shape, slope


def _hermite(planes: Array, interval: Index, t: Array) -> tuple[Array, Array]:
    """Weights of all planes at places t in [0, 1] of intervals, and their derivatives, shapes (points, planes)."""
    values, number, h = np.eye(len(planes)), np.arange(len(planes)), np.diff(planes)[interval, None]
    # The slope at each plane is that of the chord between its neighbours.
    lower, upper = np.maximum(number - 1, 0), np.minimum(number + 1, len(planes) - 1)
    slopes = (values[upper] - values[lower]) / (planes[upper] - planes[lower])[:, None]
    t = t[:, None]
    low, high = values[interval], values[interval + 1]
    low_slope, high_slope = h * slopes[interval], h * slopes[interval + 1]
    rise = t * t * (3 - 2 * t)
    shape = low + rise * (high - low) + t * (1 - t) ** 2 * low_slope - t * t * (1 - t) * high_slope
    change = 6 * t * (1 - t) * (high - low) + (1 - t) * (1 - 3 * t) * low_slope + t * (3 * t - 2) * high_slope
    return shape, change / h


def _product(along_y: Array, along_x: Array) -> Array:
    """Weights on the plane from weights along its axes, shape (points, nodes a patch)."""
    weights = along_y[:, None, :, None] * along_x[None, :, None, :]
    return np.asarray(weights.reshape(len(along_y) * len(along_x), -1))


@kernel()
def gather(shape, facet, patches, nodes):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Weighted sums of node vectors at the points, shape (points, 3)."""
    points = np.zeros((len(facet), 3))
    for q in range(len(facet)):
        for a in range(patches.shape[1]):
            node = patches[facet[q], a]
            for i in range(3):
                points[q, i] += shape[q, a] * nodes[node, i]
    return points


@kernel()
def scatter(shape, facet, patches, touching, vectors, total):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Adds vectors at some points, shape (touching, 3), to the nodes that move them, shape (nodes, 3), in place."""
    for t in range(len(touching)):
        q = touching[t]
        for a in range(patches.shape[1]):
            node = patches[facet[q], a]  # the transpose of `gather`: force and torque of points and nodes agree
            for i in range(3):
                total[node, i] += shape[q, a] * vectors[t, i]
