"""Quadrature points of the contact face: where contact is tested, and how they follow the lattice's nodes.

The face at rest is divided into facets, the rectangles of the lattice's plane z = 0. Points a facet: a regular
grid of n x n midpoints with equal weights, n odd so that the centre is one of them, spaced by at most
`POINT_SPACING_MM` and at least `MIN_POINTS`.

Between nodes the displacement is interpolated by cubics through the four nearest planes of each direction, not
bilinearly: a flat facet cuts into an object of curvature 1/R by spacing^2 / 8 R (0.03 mm at 1 mm and R = 4 mm), so
pointwise contact on flat facets would press at their middles only, 10 % too stiff and with a tenth of the contact
area. Forces go to the nodes with the same weights, so force and torque of the points are those of the nodes.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from magicsim.deform.lattice import Lattice

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
POINT_SPACING_MM = 0.35
"""Largest distance between neighbouring contact points at rest."""
MIN_POINTS = 3
"""Fewest points along a facet's edge."""
STENCIL = 4
"""Planes that one coordinate is interpolated from."""


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
        local = nodes[self.patches]
        count = len(self.facet) // len(self.patches)
        shape = self.shape.reshape(len(self.patches), count, -1)
        return np.asarray((shape @ local).reshape(-1, 3))

    def current_area_mm2(self, nodes: Array) -> Array:
        """Deformed area of each point, shape (points,) [mm2]."""
        tangents = np.einsum("qad,qai->dqi", self.slopes, nodes[self.patches[self.facet]])
        return np.asarray(self.area_mm2 * np.linalg.norm(np.cross(tangents[0], tangents[1]), axis=1))


def contact_face(lattice: Lattice) -> ContactFace:
    """The quadrature points of a lattice's contact face."""
    x, y = lattice.planes_mm[:2]
    largest = max(float(np.diff(x).max()), float(np.diff(y).max()))
    count = max(MIN_POINTS, int(np.ceil(largest / POINT_SPACING_MM)) | 1)
    first_x, shape_x, slope_x, width_x = _along(x, count)
    first_y, shape_y, slope_y, width_y = _along(y, count)
    offsets_x, offsets_y = np.arange(shape_x.shape[2]), np.arange(shape_y.shape[2])
    rows = (first_y[:, None] + offsets_y)[:, None, :, None] * len(x)
    columns = (first_x[:, None] + offsets_x)[None, :, None, :]
    facets = len(first_x) * len(first_y)
    return ContactFace(
        patches=(rows + columns).reshape(facets, -1).astype(np.int64),
        facet=np.repeat(np.arange(facets), count**2),
        shape=_product(shape_y, shape_x),
        slopes=np.stack([_product(shape_y, slope_x), _product(slope_y, shape_x)], -1),
        area_mm2=np.repeat(np.outer(width_y, width_x).ravel() / count**2, count**2),
    )


def _along(planes: Array, count: int) -> tuple[Index, Array, Array, Array]:
    """First stencil plane of each interval, weights and slopes (intervals, points, stencil), interval widths."""
    size = min(STENCIL, len(planes))
    width = np.diff(planes)
    first = np.clip(np.arange(len(width)) - (size // 2 - 1), 0, len(planes) - size)
    nodes = planes[first[:, None] + np.arange(size)][:, None, :]
    points = (planes[:-1, None] + width[:, None] * (np.arange(count) + 0.5) / count)[:, :, None]
    shape, slope = np.ones((len(width), count, size)), np.zeros((len(width), count, size))
    for a in range(size):
        for b in range(size):
            if a == b:
                continue
            run = nodes[:, :, a] - nodes[:, :, b]
            slope[:, :, a] = slope[:, :, a] * (points[:, :, 0] - nodes[:, :, b]) / run + shape[:, :, a] / run
            shape[:, :, a] *= (points[:, :, 0] - nodes[:, :, b]) / run
    return first.astype(np.int64), shape, slope, width


def _product(along_y: Array, along_x: Array) -> Array:
    """Weights on the plane from weights along its axes, shape (points, nodes a patch)."""
    weights = np.einsum("jqb,ipa->jiqpba", along_y, along_x)
    points = len(along_y) * len(along_x) * along_y.shape[1] * along_x.shape[1]
    return np.asarray(weights.reshape(points, -1))
