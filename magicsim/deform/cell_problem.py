"""Effective stiffness of a core cell: a small periodic problem on a soft cube in stiff walls.

Linear elasticity on the unit cell: walls of the body's material around a centred cube of infill, trilinear
hexahedra whose volume change is averaged over each sub-cell (selective integration: B-bar, Hughes 1980), so that a
nearly incompressible infill does not lock. The cell is a cube with the printed cell's infill volume share: the
printed pitches differ by a few percent between the axes, which this leaves out. By cubic symmetry three strain
states give C11, C12 and C44.

The lattice holds an isotropic stiffness: springs of cubic symmetry without rest length store mu/2 tr(F^T F)
whatever their weights. The nearest isotropic tensor (orthogonal projection; Voigt average) keeps the bulk modulus
and has mu = (2 (C11 - C12)/2 + 3 C44)/5; what it drops is the cubic anisotropy, whose figure is `anisotropy`.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from magicsim.deform.hexahedron import CORNERS, GAUSS_GRADIENTS

Array = npt.NDArray[np.float64]
SUBCELLS = 10
"""Sub-cells along each edge of the cell problem."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellStiffness:
    """Cubic stiffness of a core cell and its isotropic part."""

    c11_mpa: float
    """Axial stiffness along the walls [MPa]."""
    c12_mpa: float
    """Cross stiffness [MPa]."""
    c44_mpa: float
    """Shear stiffness between wall directions [MPa]."""

    @property
    def bulk_modulus_mpa(self) -> float:
        """Bulk modulus (C11 + 2 C12)/3 [MPa]; the projection keeps it."""
        return (self.c11_mpa + 2 * self.c12_mpa) / 3

    @property
    def tetragonal_modulus_mpa(self) -> float:
        """Shear modulus (C11 - C12)/2 of squeezing along the walls [MPa]."""
        return (self.c11_mpa - self.c12_mpa) / 2

    @property
    def shear_modulus_mpa(self) -> float:
        """Shear modulus mu of the nearest isotropic stiffness [MPa]."""
        return (2 * self.tetragonal_modulus_mpa + 3 * self.c44_mpa) / 5

    @property
    def lame_mpa(self) -> float:
        """First Lame parameter lambda = K - 2/3 mu of the nearest isotropic stiffness [MPa]."""
        return self.bulk_modulus_mpa - 2 / 3 * self.shear_modulus_mpa

    @property
    def anisotropy(self) -> float:
        """Zener ratio C44 / ((C11 - C12)/2): 1 is isotropic; the lattice drops the difference."""
        return self.c44_mpa / self.tetragonal_modulus_mpa


@lru_cache(maxsize=64)
def effective_stiffness(
    *, body: tuple[float, float], infill: tuple[float, float], infill_share: float, subcells: int = SUBCELLS
) -> CellStiffness:
    """Solves the periodic cell problem; cached by its numbers.

    Args:
        body: Shear and bulk modulus of the walls [MPa].
        infill: Shear and bulk modulus of the cube [MPa].
        infill_share: Volume share of the cube, in 0..1.
        subcells: Sub-cells along each edge; the material boundary always falls between two.

    Returns:
        The three cubic constants.
    """
    edges, is_infill = _subdivide(infill_share, subcells)
    shear = np.where(is_infill, infill[0], body[0])
    bulk = np.where(is_infill, infill[1], body[1])
    numbers = _periodic_numbers(subcells)
    matrices, loads, energies = _element_matrices(edges, shear, bulk)
    dofs = (3 * numbers[:, :, None] + np.arange(3)).reshape(-1, 24)
    size = 3 * subcells**3
    stiffness = sp.csc_matrix(
        (matrices.ravel(), (np.repeat(dofs, 24, 1).ravel(), np.tile(dofs, (1, 24)).ravel())), shape=(size, size)
    )
    load = np.zeros((size, 3))
    for case in range(3):
        np.add.at(load[:, case], dofs.ravel(), loads[:, case].ravel())
    fluctuation = np.zeros((size, 3))
    fluctuation[3:] = splu(stiffness[3:, 3:].tocsc()).solve(-load[3:])  # one node held against translation
    gram = energies + load.T @ fluctuation
    return CellStiffness(c11_mpa=float(gram[0, 0]), c12_mpa=float(gram[0, 1]), c44_mpa=float(gram[2, 2]))


def _subdivide(share: float, count: int) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Edges of the sub-cells, shape (count^3, 3), and which are infill; the cube fills the low corner (periodic)."""
    side = float(share) ** (1 / 3)
    inside = int(np.clip(round(side * count), 1, count - 1)) if 0 < side < 1 else count * int(side > 0)
    steps = np.concatenate(
        [
            np.full(inside, side / max(inside, 1)),
            np.full(count - inside, (1 - side) / max(count - inside, 1)),
        ]
    )
    k, j, i = (axis.ravel() for axis in np.indices((count,) * 3))
    edges = np.stack([steps[i], steps[j], steps[k]], 1)
    return edges, np.asarray((i < inside) & (j < inside) & (k < inside))


def _periodic_numbers(count: int) -> npt.NDArray[np.int64]:
    """Corner nodes of each sub-cell with opposite faces identified, shape (count^3, 8)."""
    k, j, i = (axis.ravel() for axis in np.indices((count,) * 3))
    return np.stack(
        [((k + c[2]) % count * count + (j + c[1]) % count) * count + (i + c[0]) % count for c in CORNERS], 1
    )


MACRO_STRAINS = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1]], float)
"""Mean strains xx, yy and (engineering) xy in the order xx, yy, zz, yz, xz, xy."""
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
