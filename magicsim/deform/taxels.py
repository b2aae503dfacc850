"""Forces on a grid of taxels: the contact face as a tactile array would feel it.

Taxels are rectangles of the undeformed face that move with it, as elements glued onto it do. A contact point stands for
a rectangle of the face with one traction; where taxels cut it, each takes the part that it covers. So the forces of all
taxels add up to the force of the object, and their torques to its torque, to rounding.

Images of taxels are those of the camera: row 0 at +y, column 0 at -x.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array
from magicsim.deform.contact.face import POINT_SPACING_MM, contact_face, point_boxes_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.structure import Lattice

NOTHING_MM = 1e-9
"""Widths that are rounding [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaxelGrid:
    """Rectangles of equal size over the whole contact face."""

    edges_x_mm: Array
    """Where columns begin and end, increasing, shape (columns + 1,) [mm]."""
    edges_y_mm: Array
    """Where rows begin and end, decreasing: row 0 is at +y; shape (rows + 1,) [mm]."""

    @classmethod
    def over(cls, lattice: Lattice, *, rows: int, columns: int) -> Self:
        """A grid over the face of a lattice; over that of a mirrored one, which is a quarter of the block's."""
        x, y = lattice.planes_mm[:2]
        return cls(edges_x_mm=np.linspace(x[0], x[-1], columns + 1), edges_y_mm=np.linspace(y[-1], y[0], rows + 1))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return len(self.edges_y_mm) - 1, len(self.edges_x_mm) - 1

    @property
    def centres_mm(self) -> Array:
        """Middles of the taxels on the undeformed face, shape (rows, columns, 2) [mm]."""
        x, y = ((edges[1:] + edges[:-1]) / 2 for edges in (self.edges_x_mm, self.edges_y_mm))
        return np.stack(np.meshgrid(x, y), -1)

    def largest(self, planes_x_mm: Array, planes_y_mm: Array, values: Array) -> Array:
        """Largest value of the boxes between planes that each taxel overlaps, shape (rows, columns).

        Values are of shape (ny, nx), planes increase; taxels beyond all boxes take the nearest one's.
        """
        along_x = _overlapped(planes_x_mm, self.edges_x_mm[:-1], self.edges_x_mm[1:])
        along_y = _overlapped(planes_y_mm, self.edges_y_mm[1:], self.edges_y_mm[:-1])
        rows = np.stack([values[low:high].max(0) for low, high in along_y])
        return np.stack([rows[:, low:high].max(1) for low, high in along_x], 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class TaxelForces:
    """Force and torque of an object on each taxel."""

    force_n: Array
    """Force of the object on the taxel in the sensor's frame, +z into the sensor, shape (rows, columns, 3) [N]."""
    torque_nmm: Array
    """Torque of that force about the origin, shape (rows, columns, 3) [N mm]."""
    area_mm2: Array
    """Undeformed area of the taxel, shape (rows, columns) [mm2]."""

    @property
    def traction_mpa(self) -> Array:
        """Force per undeformed area, shape (rows, columns, 3) [MPa]."""
        return np.asarray(self.force_n / self.area_mm2[..., None])


@dataclass(frozen=True, slots=True, kw_only=True)
class TaxelMap:
    """Shares of the contact points in the taxels, so that each further state costs one product."""

    grid: TaxelGrid
    share_mm2: sp.csr_matrix
    """Undeformed area of each point in each taxel, shape (taxels, points) [mm2]."""

    @classmethod
    def of(cls, lattice: Lattice, grid: TaxelGrid, *, point_spacing_mm: float = POINT_SPACING_MM) -> Self:
        """Shares of the contact points of a lattice, as far apart as those of the solver."""
        face = contact_face(lattice, point_spacing_mm=point_spacing_mm)
        low, high = point_boxes_mm(lattice, point_spacing_mm=point_spacing_mm)
        along_x = _shares(low[:, 0], high[:, 0], grid.edges_x_mm[:-1], grid.edges_x_mm[1:])
        along_y = _shares(low[:, 1], high[:, 1], grid.edges_y_mm[1:], grid.edges_y_mm[:-1])
        # A point's share of a taxel is the product of its shares of row and column.
        shares = sp.hstack([along_x.multiply(along_y[:, row]) for row in range(grid.shape[0])]).T
        return cls(grid=grid, share_mm2=sp.csr_matrix(shares.multiply(face.area_mm2)))

    def forces(self, deformation: Deformation) -> TaxelForces:
        """Forces and torques of the taxels.

        Raises:
            ValueError: The deformation has other contact points.
        """
        shape, points = self.grid.shape, self.share_mm2.shape[1]
        area = np.asarray(self.share_mm2 @ np.ones(points), np.float64).reshape(shape)
        if deformation.is_rest:
            return TaxelForces(force_n=np.zeros((*shape, 3)), torque_nmm=np.zeros((*shape, 3)), area_mm2=area)
        traction = deformation.contact_traction_mpa
        if len(traction) != points:
            raise ValueError(
                f"deformation has {len(traction)} contact points: must be the {points} of this map; "
                "give it the lattice and the point_spacing_mm of the solver"
            )
        torque = np.cross(deformation.contact_points_mm, traction)
        return TaxelForces(
            force_n=np.asarray(self.share_mm2 @ traction).reshape(*shape, 3),
            torque_nmm=np.asarray(self.share_mm2 @ torque).reshape(*shape, 3),
            area_mm2=area,
        )


def _shares(low: Array, high: Array, begin: Array, end: Array) -> sp.csc_matrix:
    """Part of each interval [low, high] that lies in each cell [begin, end], shape (intervals, cells)."""
    low, first, which = np.unique(low, return_index=True, return_inverse=True)
    high = high[first]
    common = np.minimum(high[:, None], end) - np.maximum(low[:, None], begin)
    shares = np.where(common > NOTHING_MM, common, 0.0) / (high - low)[:, None]
    return sp.csr_matrix(shares)[which].tocsc()


def _overlapped(planes: Array, begin: Array, end: Array) -> list[tuple[int, int]]:
    """First box and the one after the last that each interval overlaps; the nearest where none is."""
    last = len(planes) - 2
    first = np.clip(np.searchsorted(planes, begin + NOTHING_MM, side="right") - 1, 0, last)
    stop = np.clip(np.searchsorted(planes, end - NOTHING_MM, side="left") - 1, 0, last) + 1
    return list(zip(first.tolist(), np.maximum(stop, first + 1).tolist(), strict=True))
