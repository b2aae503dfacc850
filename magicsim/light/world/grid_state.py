"""What both passes ask of the deformed grid, computed once for each state of its mesh."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.printed_cells import FusedCells
from magicsim.light.backend import mi
from magicsim.light.cells.cell_faces import CellFaces, cell_faces
from magicsim.light.cells.cell_topology import CellTopology
from magicsim.light.world.shapes import mesh_of


@dataclass(frozen=True, kw_only=True)
class GridState:
    """What is known of the cells as they are deformed."""

    mesh: SurfaceMesh
    cells: int
    """Their number."""
    centres_mm: Array
    """Mean of the vertices of each cell, shape (cells, 3) [mm]."""
    faces: CellFaces | None
    """For `next_hit`; None to search among all triangles for every hit."""

    @cached_property
    def volumes_mm3(self) -> Array:
        """Shape (cells,) [mm3]."""
        return cell_volumes_mm3(self.mesh.vertices, self.mesh.faces, self.cells)


class GridStates:
    """Keeps the state of a mesh until its vertices are replaced."""

    def __init__(self, triangles_per_cell: int, topology: CellTopology | None, fused: FusedCells | None = None) -> None:
        """For an infill of disjoint cells.

        Args:
            triangles_per_cell: Of each of them.
            topology: How they are put together: hits are then looked for in the cell that a ray is in. None to search
                for them among all triangles.
            fused: Cells without a wall between them: hits in and beside them are searched for.
        """
        self._triangles_per_cell, self._topology, self._fused = triangles_per_cell, topology, fused
        self._positions: Any = None
        self._state: GridState | None = None

    def of(self, infill: Any, strangers: Sequence[Any]) -> GridState:
        """State of the cells.

        Args:
            infill: Their shape.
            strangers: Shapes that may reach into the grid, as LED strips do under a thin skin; where one does, all hits
                are searched for.
        """
        positions = mi.traverse(infill)["vertex_positions"]
        # Replaced vertices are another variable. The one kept here stays alive, so that its index is not used again; it
        # is a handle of our own, because what the mesh hands out follows the mesh.
        if self._state is None or self._positions.index != positions.index:
            state = self._computed(mesh_of(infill), infill.bbox(), strangers)
            self._positions, self._state = mi.Float(positions), state
        return self._state

    def _computed(self, mesh: SurfaceMesh, box: Any, strangers: Sequence[Any]) -> GridState:
        cells = len(mesh.faces) // self._triangles_per_cell
        pairs = None
        if self._fused is not None:
            mesh, pairs = SurfaceMesh(vertices=mesh.vertices, faces=self._fused.closed), self._fused.pairs
        alone = not any(box.overlaps(shape.bbox()) for shape in strangers)
        return GridState(
            mesh=mesh,
            cells=cells,
            centres_mm=mesh.vertices.reshape(cells, -1, 3).mean(1),
            faces=cell_faces(mesh.vertices, self._topology, pairs) if self._topology is not None and alone else None,
        )


def cell_volumes_mm3(vertices: Array, faces: npt.NDArray[np.int32], cells: int) -> Array:
    """Volume of each deformed cell by the divergence theorem, shape (cells,) [mm3].

    Args:
        vertices: Shape (vertices, 3) [mm].
        faces: Cell-major vertex indices, shape (triangles, 3).
        cells: Number of cells.
    """
    corners = vertices[faces].reshape(cells, -1, 3, 3)
    corners = corners - corners[:, :1, :1]
    return np.asarray(np.einsum("cti,cti->c", corners[:, :, 0], np.cross(corners[:, :, 1], corners[:, :, 2])) / 6)
