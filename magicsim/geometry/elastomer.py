"""The printed block as closed meshes: the body with its skin, and the infill cells inside it."""

from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt

from magicsim.errors import GeometryError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid, resolve_grid, split_count
from magicsim.geometry.mesh import SurfaceMesh, from_manifold

FACE_EDGE_MM = 0.5
"""Length to which the edges of the block are split [mm]: fine enough to bend around a fingertip-sized object.
Diagonals of the triangles inside a face are up to twice as long."""
VOLUME_TOLERANCE = 1e-6
ON_FACE_MM = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Elastomer:
    """A design made solid. The walls and the skin are what lies in `body` and outside `infill`."""

    design: ElastomerDesign
    grid: CellGrid | None
    body: SurfaceMesh
    """Outer surface of the block."""
    infill: SurfaceMesh | None
    """All infill cells, disjoint, x-fastest; cell of a triangle is `triangle // triangles_per_cell`."""
    triangles_per_cell: int

    @property
    def is_face(self) -> npt.NDArray[np.bool_]:
        """Body vertices on the contact face, shape (body vertices,)."""
        return np.asarray(self.body.vertices[:, 2] < ON_FACE_MM)


def build_elastomer(design: ElastomerDesign) -> Elastomer:
    """Builds the meshes of a design and checks them against the closed form.

    Raises:
        GeometryError: The grid does not fit, or a mesh is not watertight or has the wrong volume.
    """
    grid = resolve_grid(design)
    body = _block(design)
    _check("body", body, float(np.prod([*design.footprint_mm, design.height_mm])))
    if grid is None:
        return Elastomer(design=design, grid=None, body=body, infill=None, triangles_per_cell=0)
    infill = _cells(grid, subdivision(design, grid))
    _check("infill", infill, grid.infill_volume_mm3)
    return Elastomer(
        design=design,
        grid=grid,
        body=body,
        infill=infill,
        triangles_per_cell=len(infill.faces) // grid.cell_count,
    )


def _block(design: ElastomerDesign) -> SurfaceMesh:
    width, length = design.footprint_mm
    block = manifold3d.Manifold.cube((width, length, design.height_mm))
    edge = min(FACE_EDGE_MM, design.skin_mm)
    return from_manifold(block.translate((-width / 2, -length / 2, 0)).refine_to_length(max(edge, 0.25)))


def subdivision(design: ElastomerDesign, grid: CellGrid) -> int:
    """Parts into which the edges of an infill cell are split: as many as the lattice has cells along a pitch.

    At least two, so that a pressed cell can bulge and its walls bend.
    """
    return max(2, *(split_count(pitch, design.lattice.spacing_mm or pitch) for pitch in grid.pitch_mm.tolist()))


def _cells(grid: CellGrid, parts: int) -> SurfaceMesh:
    cube = manifold3d.Manifold.cube(tuple(grid.cell_mm), True)
    cube = cube.refine(parts) if parts > 1 else cube
    cell = from_manifold(cube)
    vertices = (grid.centres_mm()[:, None] + cell.vertices).reshape(-1, 3)
    first = np.arange(grid.cell_count, dtype=np.int32) * len(cell.vertices)
    return SurfaceMesh(vertices=vertices, faces=(first[:, None, None] + cell.faces).reshape(-1, 3))


def _check(name: str, mesh: SurfaceMesh, volume_mm3: float) -> None:
    if not mesh.is_watertight():
        msg = f"the {name} mesh is not watertight"
        raise GeometryError(msg)
    error = mesh.volume_mm3() / volume_mm3 - 1
    if abs(error) > VOLUME_TOLERANCE:
        found = f"{mesh.volume_mm3():.6g} mm3, {error:+.2g} off the closed form {volume_mm3:.6g} mm3"
        msg = f"the {name} mesh has volume {found}"
        raise GeometryError(msg)
