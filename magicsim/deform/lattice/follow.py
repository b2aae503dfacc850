"""Arbitrary points follow the lattice by the trilinear map of rest positions, and below the pitch their printed cell.

The lattice's nodes stand for the crossings of the walls. Between them a cell follows its mean strain but for a
periodic fluctuation chi, linear in that strain and zero at the crossings: stiff walls strain less than the soft
infill, which makes them tilt and bend, and the infill bulge. With the mean deformation gradient F = R U of a printed
cell, a point at xi of its unit cell stands at

    trilinear position + R chi(xi) : ln U.

The logarithm is not a matter of taste: its trace is ln det F, so that a stretch at constant volume does not read as
swelling, to which walls and infill respond very differently. U - I and Green's strain miss the periodic neo-Hookean
cell by two to four times as much at 30 %.

F is the mean over the printed cell, from its eight crossings, however finely the lattice splits it. One strain for
each cell is enough: infill cells do not share surfaces, so nothing has to match between neighbours.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from magicsim.arrays import Array
from magicsim.deform.lattice.cell_problem import CellFields, printed_fields
from magicsim.deform.lattice.hexahedron import CORNERS, shape_gradients, shape_values
from magicsim.deform.lattice.structure import Lattice, located
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowMap:
    """Weights of the lattice's nodes at fixed points, so that each further frame costs one product."""

    points_mm: Array
    """Rest positions, shape (points, 3) [mm]."""
    weights: sp.csr_matrix
    """Trilinear weights, shape (points, nodes)."""

    def displaced(self, displacements_mm: Array) -> Array:
        """Positions under nodal displacements of shape (nodes, 3), shape (points, 3) [mm]."""
        return np.asarray(self.points_mm + self.weights @ displacements_mm)


def follow_map(lattice: Lattice, points_mm: Array) -> FollowMap:
    """Cell and weights of each point at rest [mm]; one outside moves with the nearest point of the block."""
    boxed = lattice.flattened(points_mm)
    places = [located(planes, boxed[:, axis]) for axis, planes in enumerate(lattice.planes_mm)]
    i, j, k = (cell for cell, _ in places)
    nx, ny = len(lattice.planes_mm[0]), len(lattice.planes_mm[1])
    nodes = np.stack([((k + c[2]) * ny + j + c[1]) * nx + i + c[0] for c in CORNERS], 1)
    values = shape_values(np.stack([part for _, part in places], 1))
    rows = np.arange(0, 8 * len(points_mm) + 1, 8)
    weights = sp.csr_matrix((values.ravel(), nodes.ravel(), rows), shape=(len(points_mm), len(lattice.nodes_mm)))
    return FollowMap(points_mm=np.asarray(points_mm, float), weights=weights)


STRAINS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Mean strains xx, yy, zz, 2 yz, 2 xz, 2 xy by the axes they couple."""


def fluctuation(fields: CellFields, points: Array) -> Array:
    """Periodic fluctuation chi at points of the unit cell, in 0..1, shape (points, 3): (points, 3, unit `STRAINS`)."""
    values = np.empty((len(points), 3, 6))
    for case, (first, second) in enumerate(STRAINS):
        rest = [axis for axis in range(3) if axis not in (first, second)]
        order = [first, *rest] if first == second else [first, second, *rest]  # axes that play x, y and z
        values[:, order, case] = _canonical(fields, points[:, order], is_shear=first != second)
    return values


def _canonical(fields: CellFields, points: Array, *, is_shear: bool) -> Array:
    """Fluctuation for xx or 2 xy, unfolded from the eighth by its mirrors, shape (points, 3)."""
    mirror = np.where(points > 1 / 2, -1.0, 1.0)
    cell, local = located(fields.planes, np.minimum(points, 1 - points))
    i, j, k = (cell[:, None, :] + CORNERS).transpose(2, 0, 1)
    field = fields.shear if is_shear else fields.axial
    eighth = np.einsum("pc,pci->pi", shape_values(local), field[k, j, i])
    return np.asarray(eighth * mirror * (mirror[:, :1] * mirror[:, 1:2] if is_shear else 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class CellCorrectors:
    """Points that follow the lattice and, below the pitch, their printed cell."""

    follow: FollowMap
    gradient: sp.csr_matrix
    """Mean displacement gradient of each printed cell from nodal displacements, shape (3 cells, nodes) [1/mm]."""
    fluctuation_mm: Array
    """Fluctuation of the points of a cell, by direction and by the six unit `STRAINS`, shape (points, 18) [mm]."""

    @property
    def points_mm(self) -> Array:
        """Rest positions, shape (points, 3) [mm]."""
        return self.follow.points_mm

    def deformation_gradient(self, displacements_mm: Array) -> Array:
        """Mean deformation gradient of each printed cell under nodal displacements, shape (cells, 3, 3)."""
        gradient = np.asarray(self.gradient @ displacements_mm).reshape(-1, 3, 3)
        return np.asarray(np.eye(3) + gradient.transpose(0, 2, 1))

    def displaced(self, displacements_mm: Array) -> Array:
        """Positions under nodal displacements of shape (nodes, 3), shape (points, 3) [mm]."""
        rotation, strain = rotation_and_strain(self.deformation_gradient(displacements_mm))
        turned = rotation.transpose(0, 2, 1)[:, :, None] * strain_components(strain)[:, None, :, None]
        positions = self.fluctuation_mm @ turned.reshape(-1, 18, 3)  # (cells, points, 3)
        positions += self.follow.displaced(displacements_mm).reshape(positions.shape)
        return np.asarray(positions.reshape(-1, 3))


SMALLEST_STRETCH = 0.05
"""Stretch below which the logarithm is cut off: assumed."""


def rotation_and_strain(gradient: Array) -> tuple[Array, Array]:
    """Rotation R and logarithmic strain ln U of F = R U, each of shape (count, 3, 3)."""
    left, stretches, right = np.linalg.svd(gradient)
    logarithms = np.log(np.maximum(stretches, SMALLEST_STRETCH))
    return left @ right, (right.transpose(0, 2, 1) * logarithms[:, None]) @ right


def strain_components(strain: Array) -> Array:
    """The six `STRAINS` of symmetric tensors, shear doubled, shape (count, 6)."""
    return np.stack([strain[:, a, b] * (1 if a == b else 2) for a, b in STRAINS], 1)


def cell_correctors(
    design: ElastomerDesign, grid: CellGrid | None, lattice: Lattice, points_mm: Array, cell_mm: Array | None = None
) -> CellCorrectors | None:
    """Hangs points of the infill on the lattice and on the cell problem; None without a grid or without infill.

    Rest positions are of shape (cells * points a cell, 3) [mm], cells x-fastest and all alike, as `geometry.elastomer`
    tiles them; those of a drawn cell about its middle of shape (points a cell, 3) [mm], the first cell's by default.
    Node planes of the grid that the lattice leaves out are interpolated.
    """
    fields = printed_fields(design, grid)
    if grid is None or fields is None:
        return None
    corner = grid.centres_mm() - grid.pitch_mm / 2
    first = design.flattened(points_mm[: len(points_mm) // grid.cell_count]) - corner[0]
    inside = first if cell_mm is None else cell_mm + grid.pitch_mm / 2
    chi = fluctuation(fields, _unit_cell(inside, grid, fields.half_wall)) * grid.pitch_mm[:, None]
    return CellCorrectors(
        follow=follow_map(lattice, points_mm),
        gradient=mean_gradient(lattice, corner, grid.pitch_mm, design),
        fluctuation_mm=chi.reshape(-1, 18),
    )


def _unit_cell(points_mm: Array, grid: CellGrid, half_wall: float) -> Array:
    """Positions in the unit cell, interface on interface: wall and infill are stretched apart, shape (points, 3)."""
    printed = (1 - grid.cell_mm / grid.pitch_mm) / 2
    ends = (half_wall, 1 - half_wall)
    return np.stack(
        [
            np.interp(points_mm[:, axis] / grid.pitch_mm[axis], [0, wall, 1 - wall, 1], [0, *ends, 1])
            for axis, wall in enumerate(printed)
        ],
        1,
    )


def mean_gradient(lattice: Lattice, corner_mm: Array, pitch_mm: Array, design: ElastomerDesign) -> sp.csr_matrix:
    """Mean displacement gradient of boxes from nodal displacements, shape (3 boxes, nodes) [1/mm].

    The mean over a box of a trilinear field's gradient is its gradient in the middle.
    """
    crossings = (corner_mm[:, None] + CORNERS * pitch_mm).reshape(-1, 3)
    centre = shape_gradients(np.full((1, 3), 0.5))[0] / pitch_mm  # (8, 3)
    local = sp.kron(sp.identity(len(corner_mm)), centre.T)
    if design.face is not None:
        placed = design.lifted(crossings)
        turned = np.asarray(local @ placed).reshape(-1, 3, 3)  # of each cell, its map's derivatives by the box's axes
        local, crossings = sp.block_diag(np.linalg.inv(turned)) @ local, placed
    return sp.csr_matrix(local @ follow_map(lattice, crossings).weights)
