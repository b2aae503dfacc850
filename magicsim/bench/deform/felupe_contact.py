"""Contact of a rigid sphere with a face, as an item for felupe: it has planes and cylinders only.

A penalty at the quadrature points of the face's facets, with its consistent stiffness. Points rather than nodes, as
nodal contact was less accurate at the same mesh.
"""

from typing import Any

import felupe
import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array


class SphereContact:
    """Follows felupe's protocol of an item: `assemble.vector`, `assemble.matrix`, `results`."""

    def __init__(self, field: Any, face: Any, *, radius_mm: float, penalty: float) -> None:  # noqa: ANN401
        """Prepares the face.

        Args:
            field: Container with the displacement as its first field.
            face: Boundary region of the hexahedra.
            radius_mm: Of the sphere, whose centre is on the z axis.
            penalty: Traction per penetration [N/mm3].
        """
        self.field = field
        self.radius_mm, self.penalty = radius_mm, penalty
        self.depth_mm = 0.0
        self.results = felupe.mechanics.Results()
        self.assemble = felupe.mechanics.Assemble(vector=self._vector, matrix=self._matrix)
        self._cells = face.mesh.cells
        self._shape = face.h.reshape(*face.h.shape[:2])
        self._area = face.dV.T
        self._rest = field.region.mesh.points
        self._dofs = (3 * self._cells[:, :, None] + np.arange(3)).reshape(len(self._cells), -1)

    @property
    def force_n(self) -> Array:
        """Force of the sphere on the meshed part, shape (3,) [N]."""
        gap, normal, _ = self._gaps()
        pressure = -self.penalty * np.minimum(gap, 0) * self._area
        return np.asarray(np.einsum("cq,cqi->i", pressure, normal))

    @property
    def contact_area_mm2(self) -> float:
        """Deformed area of the quadrature points inside the sphere, a facet's nodes in x and y order assumed."""
        gap = self._gaps()[0]
        return float((self._deformed_area() * (gap < 0)).sum())

    def _gaps(self) -> tuple[Array, Array, Array]:
        """Gap, normal and distance to the centre at the quadrature points, shape (facets, points[, 3])."""
        positions = self._rest + self.field[0].values
        points = np.einsum("cai,aq->cqi", positions[self._cells], self._shape)
        offset = points - [0.0, 0.0, self.depth_mm - self.radius_mm]
        length = np.linalg.norm(offset, axis=2)
        return length - self.radius_mm, offset / length[..., None], length

    def _deformed_area(self) -> Array:
        """Area of each point, the facet's own deformed area shared in proportion, shape (facets, points) [mm2]."""
        on_face = np.flatnonzero(self._shape.any(1))
        corners = (self._rest + self.field[0].values)[self._cells[:, on_face]]
        rest = self._rest[self._cells[:, on_face]]
        return np.asarray(self._area * (_quad_area(corners) / _quad_area(rest))[:, None])

    def _vector(self, field: Any = None, parallel: bool = False) -> Any:  # noqa: ANN401
        del parallel
        self.field = field or self.field
        gap, normal, _ = self._gaps()
        pressure = -self.penalty * np.minimum(gap, 0) * self._area
        force = np.einsum("cq,cqi,aq->cai", pressure, normal, self._shape).reshape(len(self._cells), -1)
        vector = np.bincount(self._dofs.ravel(), -force.ravel(), minlength=self._rest.size)
        self.results.force = sp.csr_matrix(vector[:, None])
        return self.results.force

    def _matrix(self, field: Any = None, parallel: bool = False) -> Any:  # noqa: ANN401
        del parallel
        self.field = field or self.field
        gap, normal, length = self._gaps()
        hit = np.flatnonzero((gap < 0).any(1))
        gap, normal, length = gap[hit], normal[hit], length[hit]
        along = normal[..., :, None] * normal[..., None, :]
        local = along + (gap / length)[..., None, None] * (np.eye(3) - along)
        local *= (self.penalty * (gap < 0) * self._area[hit])[..., None, None]
        size = self._dofs.shape[1]
        blocks = np.einsum("cqij,aq,bq->caibj", local, self._shape, self._shape, optimize=True)
        blocks = blocks.reshape(len(hit), size, size)
        rows = np.broadcast_to(self._dofs[hit][:, :, None], blocks.shape)
        columns = np.broadcast_to(self._dofs[hit][:, None, :], blocks.shape)
        entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
        self.results.stiffness = sp.csr_matrix(entries, shape=(self._rest.size,) * 2)
        return self.results.stiffness


def _quad_area(corners: Array) -> Array:
    """Area of quadrilaterals from the cross product of their diagonals, shape (count,)."""
    diagonals = np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
    return np.asarray(diagonals / 2)
