"""A core cell from the inside: the periodic problem on a soft cube in stiff walls, its stiffness and displacement.

Linear elasticity on the unit cell: walls of the body's material around a centred cube of infill, trilinear
hexahedra whose volume change is averaged over each sub-cell (selective integration: B-bar, Hughes 1980), so that a
nearly incompressible infill does not lock. The cell is a cube with the printed cell's infill volume share: the
printed pitches differ by a few percent between the axes, which this leaves out.

The cell has cubic symmetry. Two mean strains, xx and xy, give C11, C12 and C44, and permuting the axes gives the other
four. Mirrors leave an eighth of the cell: for xx the normal displacement vanishes on its six planes; for xy the mirrors
across x and y change the sign, so there the tangential displacement vanishes instead. The fluctuation, which is what
the cell adds to its mean strain, is then zero at the crossings of the walls and in the middle of the infill without
further ado. Sub-cells shrink towards the interface, whose edges are singular.

A lattice cell keeps all three constants: mu = C44, walls of modulus beta = (C11 - C12)/2 - C44 that carry load along
x, y and z alone, and lambda from the bulk modulus.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from magicsim.arrays import Array, Mask
from magicsim.deform.lattice.hexahedron import CORNERS, GAUSS_GRADIENTS
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid

SUBCELLS = 8
"""Sub-cells along each half edge of the cell: the shear stiffness is then within 0.5 % of its limit."""
WALL_SHARE = 0.3
"""Share of the sub-cells that lies in the half wall: assumed."""
INFILL_GRADING = 2.0
"""Exponent by which sub-cells shrink towards the interface from the middle of the infill: assumed."""
WALL_GRADING = 1.5
"""Exponent by which sub-cells shrink towards the interface from the middle of the wall: assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellStiffness:
    """Cubic stiffness of a core cell, and what the lattice makes of it."""

    c11_mpa: float
    """Axial stiffness along the walls [MPa]."""
    c12_mpa: float
    c44_mpa: float
    """Shear stiffness between wall directions [MPa]."""

    @property
    def bulk_modulus_mpa(self) -> float:
        """Bulk modulus (C11 + 2 C12)/3 [MPa]."""
        return (self.c11_mpa + 2 * self.c12_mpa) / 3

    @property
    def tetragonal_modulus_mpa(self) -> float:
        """Shear modulus (C11 - C12)/2 of squeezing along the walls [MPa]."""
        return (self.c11_mpa - self.c12_mpa) / 2

    @property
    def shear_modulus_mpa(self) -> float:
        """Shear modulus mu = C44 of the network [MPa]."""
        return self.c44_mpa

    @property
    def wall_modulus_mpa(self) -> float:
        """Modulus beta = (C11 - C12)/2 - C44 of the walls [MPa]: energy beta eps_kk^2 per volume and axis k."""
        return self.tetragonal_modulus_mpa - self.c44_mpa

    @property
    def isotropic_modulus_mpa(self) -> float:
        """Shear modulus mu + 2/5 beta of the nearest isotropic cell [MPa]."""
        return self.shear_modulus_mpa + 2 / 5 * self.wall_modulus_mpa

    @property
    def lame_mpa(self) -> float:
        """First Lame parameter lambda = K - 2/3 mu - 2/3 beta of the cell pressure [MPa]; equals C12."""
        return self.bulk_modulus_mpa - 2 / 3 * self.tetragonal_modulus_mpa


@dataclass(frozen=True, slots=True, kw_only=True)
class CellFields:
    """Solution of the cell problem on the eighth of a unit cell that is nearest to the origin."""

    stiffness: CellStiffness
    planes: Array
    """Node planes along each half edge, from the middle of the wall to the middle of the infill, in units of the
    pitch, shape (subcells + 1,)."""
    half_wall: float
    """Where the wall ends, in units of the pitch; 0 without walls, 1/2 without infill."""
    axial: Array
    """Fluctuation for the mean strain xx = 1 in units of the pitch, shape (n, n, n, 3) over z, y, x."""
    shear: Array
    """Fluctuation for the mean strain 2 xy = 1, same shape."""


def printed_fields(
    design: ElastomerDesign, grid: CellGrid | None, *, added_mpa: float = 0.0, walls: float = 1.0, gel: float = 1.0
) -> CellFields | None:
    """Solution of the cell problem of a block, None where it has no cells.

    The body has a shear modulus added [MPa]; walls and infill carry a share of their shear, and all of their volume.
    """
    body, infill = design.materials.body, design.materials.infill
    if grid is None or infill is None:
        return None
    return cell_fields(
        body=(walls * (body.shear_modulus_mpa + added_mpa), body.bulk_modulus_mpa + 2 / 3 * added_mpa),
        infill=(gel * infill.shear_modulus_mpa, infill.bulk_modulus_mpa),
        infill_share=float(np.prod(grid.cell_mm / grid.pitch_mm)),
    )


@lru_cache(maxsize=64)
def cell_fields(
    *, body: tuple[float, float], infill: tuple[float, float], infill_share: float, subcells: int = SUBCELLS
) -> CellFields:
    """Solves the periodic cell problem; cached by its numbers.

    Moduli are pairs of shear and bulk [MPa]. There are at least 2 sub-cells along each half edge, and the material
    boundary always falls between two.
    """
    planes, in_wall = _half_edge(infill_share, subcells)
    k, j, i = (axis.ravel() for axis in np.indices((subcells,) * 3))
    sizes = np.diff(planes)[np.stack([i, j, k], 1)]
    is_infill = (i >= in_wall) & (j >= in_wall) & (k >= in_wall)
    shear, bulk = np.where(is_infill, infill[0], body[0]), np.where(is_infill, infill[1], body[1])
    matrices, loads, energies = _element_matrices(sizes, shear, bulk)
    count = subcells + 1
    nodes = np.stack([((k + c[2]) * count + j + c[1]) * count + i + c[0] for c in CORNERS], 1)
    dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(-1, 24)
    stiffness = sp.csr_matrix(
        (matrices.ravel(), (np.repeat(dofs, 24, 1).ravel(), np.tile(dofs, (1, 24)).ravel())), shape=(3 * count**3,) * 2
    )
    load = np.zeros((3 * count**3, 3))
    for case in range(3):
        np.add.at(load[:, case], dofs.ravel(), loads[:, case].ravel())
    axial, sheared = np.zeros(len(load)), np.zeros(len(load))
    for found, case, sign in ((axial, XX, False), (sheared, XY, True)):
        moving = _moving(count, sign)
        factor = splu(stiffness[moving][:, moving].tocsc(), permc_spec="MMD_AT_PLUS_A")
        found[moving] = factor.solve(-load[moving, case])
    c11 = energies[XX, XX] + load[:, XX] @ axial
    c12 = energies[XX, YY] + load[:, YY] @ axial
    c44 = energies[XY, XY] + load[:, XY] @ sheared
    shape = (count,) * 3 + (3,)
    return CellFields(
        stiffness=CellStiffness(c11_mpa=8 * float(c11), c12_mpa=8 * float(c12), c44_mpa=8 * float(c44)),
        planes=planes,
        half_wall=float(planes[in_wall]),
        axial=axial.reshape(shape),
        shear=sheared.reshape(shape),
    )


def _half_edge(share: float, count: int) -> tuple[Array, int]:
    """Node planes from the middle of the wall to that of the infill, and how many sub-cells lie in the wall."""
    half_infill = float(share) ** (1 / 3) / 2
    in_wall = max(1, round(WALL_SHARE * count)) if 0 < share < 1 else count * int(share <= 0)
    wall = (0.5 - half_infill) * (1 - np.linspace(1, 0, in_wall + 1) ** WALL_GRADING)
    infill = 0.5 - half_infill * (1 - np.linspace(0, 1, count - in_wall + 1) ** INFILL_GRADING)
    return np.concatenate([wall[:-1], infill]), in_wall


def _moving(count: int, antisymmetric: bool) -> Mask:
    """Free displacements of the eighth's nodes, shape (3 nodes,); mirrors change the sign for xy and do not for xx."""
    index = np.indices((count,) * 3).reshape(3, -1)[::-1].T  # x, y, z of each node
    on_plane = (index == 0) | (index == count - 1)  # (nodes, axis)
    moving = np.ones((len(index), 3), bool)
    for axis in range(3):
        flips = antisymmetric and axis < 2  # noqa: PLR2004 -- x and y
        held = [other for other in range(3) if (other != axis) == flips]
        moving[np.ix_(on_plane[:, axis], held)] = False
    return moving.ravel()


MACRO_STRAINS = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1]], float)
"""Mean strains xx, yy and (engineering) xy in the order xx, yy, zz, yz, xz, xy."""
XX, YY, XY = range(3)
DEVIATOR = np.diag([2, 2, 2, 1, 1, 1.0]) - np.pad(np.full((3, 3), 2 / 3), (0, 3))
"""Isotropic stiffness of unit shear and no bulk modulus, engineering shear strains."""


def _element_matrices(edges: Array, shear: Array, bulk: Array) -> tuple[Array, Array, Array]:
    """Stiffness (cells, 24, 24), load of each mean strain (cells, 3, 24), energy of the mean strains (3, 3)."""
    volume = edges.prod(1)
    gradients = GAUSS_GRADIENTS[None] / edges[:, None, None, :]  # (cells, points, corners, 3)
    strain = _strain_matrix(gradients)
    dilation = strain[:, :, :3].sum(2).mean(1)  # averaged over the sub-cell
    weight = shear * volume / 8
    matrices = np.einsum("e,eqai,ab,eqbj->eij", weight, strain, DEVIATOR, strain, optimize=True)
    matrices += np.einsum("e,ei,ej->eij", bulk * volume, dilation, dilation, optimize=True)
    traces = MACRO_STRAINS[:, :3].sum(1)
    loads = np.einsum("e,ca,ab,eqbj->ecj", weight, MACRO_STRAINS, DEVIATOR, strain, optimize=True)
    loads += (bulk * volume)[:, None, None] * traces[None, :, None] * dilation[:, None, :]
    mean_shear, mean_bulk = float(shear @ volume), float(bulk @ volume)
    energies = mean_shear * (MACRO_STRAINS @ DEVIATOR @ MACRO_STRAINS.T) + mean_bulk * np.outer(traces, traces)
    return matrices, loads, energies


def _strain_matrix(gradients: Array) -> Array:
    """Strain from corner displacements, shape (cells, points, 6, 24), engineering shear strains."""
    cells, points = gradients.shape[:2]
    strain = np.zeros((cells, points, 6, 8, 3))
    for axis in range(3):
        strain[:, :, axis, :, axis] = gradients[..., axis]
    for row, (first, second) in zip((3, 4, 5), ((1, 2), (0, 2), (0, 1)), strict=True):
        strain[:, :, row, :, first] = gradients[..., second]
        strain[:, :, row, :, second] = gradients[..., first]
    return strain.reshape(cells, points, 6, 24)
