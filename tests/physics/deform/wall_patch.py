"""A printed block of few cells with walls and infill meshed apart, and its effective lattice, between bonded plates.

The reference is written with NumPy alone and shares nothing with the package's kernels but the hexahedron's shape
functions: neo-Hookean mu/2 (I1 - 3) - mu ln J at 2 x 2 x 2 Gauss points, lambda/2 (Jbar - 1)^2 of each element's mean
dilatation. A quarter of the block is meshed: y is a mirror, and half a turn about y maps the lower half to the upper.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from magicsim.deform.contact.face import contact_face
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.hexahedron import GAUSS_GRADIENTS
from magicsim.deform.lattice.pattern import block_pattern
from magicsim.deform.lattice.structure import Lattice, box_lattice
from magicsim.deform.solve.factorise import symmetric_solver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import CellGrid

PERMUTATION = np.zeros((3, 3, 3))
PERMUTATION[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1
PERMUTATION[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1
TOLERANCE_MM = 1e-9
RESIDUAL = 1e-7


class NeoHookeanBoxes:
    """Box elements with a shear and a Lame modulus each."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.volumes = lattice.sizes_mm.prod(1)
        self.dofs = (3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)
        self.gradients = GAUSS_GRADIENTS[None] / lattice.sizes_mm[:, None, None, :]
        self.network = np.einsum(
            "c,cqpk,cqrk->cpr", lattice.shear_modulus_mpa * self.volumes / 8, self.gradients, self.gradients
        )

    def linearise(self, positions: np.ndarray, pressure: np.ndarray) -> "Linearised":
        weight, mu = self.volumes / 8, self.lattice.shear_modulus_mpa
        corners = positions[self.lattice.cells]
        f = np.einsum("cpi,cqpk->cqik", corners, self.gradients, optimize=True)
        cofactor = np.stack([np.cross(f[:, :, (i + 1) % 3], f[:, :, (i + 2) % 3]) for i in range(3)], 2)
        jacobian = (f[:, :, 0] * cofactor[:, :, 0]).sum(-1)
        g = np.einsum("cqik,cqpk->cqpi", cofactor, self.gradients, optimize=True).reshape(len(weight), 8, 24)
        volume_gradient = np.einsum("c,cqa->ca", weight, g)
        dilatation = jacobian.mean(1)
        force = (self.network @ corners).reshape(-1, 24)
        force -= np.einsum("cq,cqa->ca", (mu * weight)[:, None] / jacobian, g)
        force += (self.lattice.lame_mpa * (dilatation - 1))[:, None] * volume_gradient
        matrix = np.ascontiguousarray(
            g.transpose(0, 2, 1) @ ((mu * weight)[:, None, None] / jacobian[..., None] ** 2 * g)
        )
        matrix += np.einsum("c,ca,cb->cab", self.lattice.lame_mpa / self.volumes, volume_gradient, volume_gradient)
        blocks = matrix.reshape(-1, 8, 3, 8, 3)  # a view
        for i in range(3):
            blocks[:, :, i, :, i] += self.network
        geometric = -(mu * weight)[:, None] / jacobian + (pressure * weight)[:, None]
        axial = np.einsum("cq,cqmn,kln->cqmkl", geometric, f, PERMUTATION, optimize=True)
        twist = np.einsum("cqmkl,cqpk,cqrl->cmpr", axial, self.gradients, self.gradients, optimize=True)
        for i, j, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            blocks[:, :, i, :, j] += twist[:, m]
            blocks[:, :, j, :, i] -= twist[:, m]
        rows, columns = np.repeat(self.dofs, 24, 1).ravel(), np.tile(self.dofs, (1, 24)).ravel()
        return Linearised(
            gradient=np.bincount(self.dofs.ravel(), force.ravel(), positions.size),
            hessian=sp.csr_matrix((matrix.ravel(), (rows, columns)), shape=(positions.size,) * 2),
            dilatation=dilatation,
            volume_gradient=volume_gradient,
            min_jacobian=float(jacobian.min()),
        )


class NetworkLattice:
    """The package's lattice in the same clothes; its bonded plane has no rows."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.volumes = lattice.sizes_mm.prod(1)
        self.dofs = (3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)
        self.elasticity = Elasticity.of(lattice)
        self.pattern = block_pattern(lattice, contact_face(lattice).patches)

    def linearise(self, positions: np.ndarray, pressure: np.ndarray) -> "Linearised":
        state = self.elasticity.evaluate(positions)
        values = self.elasticity.hessian(positions, pressure, state.volume_gradient, self.pattern, shift=0.0)
        upper = sp.csr_matrix((values, self.pattern.indices, self.pattern.indptr), shape=(self.pattern.size,) * 2)
        full = sp.csr_matrix(upper + sp.triu(upper, 1).T)
        full.resize((positions.size,) * 2)
        return Linearised(
            gradient=state.gradient.ravel(),
            hessian=full,
            dilatation=state.jacobian,
            volume_gradient=state.volume_gradient,
            min_jacobian=state.min_jacobian,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Linearised:
    gradient: np.ndarray
    hessian: sp.csr_matrix
    dilatation: np.ndarray
    volume_gradient: np.ndarray
    min_jacobian: float


class ReducedMatrix:
    """Factorises moving^T K moving; SciPy's products drop zeros, so the entries are put back in a fixed pattern."""

    def __init__(self, moving: sp.csr_matrix, dofs: np.ndarray) -> None:
        self.moving = moving
        rows, columns = np.repeat(dofs, 24, 1).ravel(), np.tile(dofs, (1, 24)).ravel()
        ones = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(moving.shape[0],) * 2)
        pattern = sp.csr_matrix(sp.triu(abs(moving).T @ ones @ abs(moving)))
        pattern.sort_indices()
        self.keys = self._keys(pattern)
        self.solver = symmetric_solver(pattern.indptr, pattern.indices)

    @staticmethod
    def _keys(matrix: sp.csr_matrix) -> np.ndarray:
        rows = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
        return rows * matrix.shape[1] + matrix.indices

    def factorise(self, hessian: sp.csr_matrix) -> bool:
        upper = sp.csr_matrix(sp.triu(self.moving.T @ hessian @ self.moving))
        values = np.zeros(len(self.keys))
        values[np.searchsorted(self.keys, self._keys(upper))] = upper.data
        return self.solver.factorise(values)


@dataclass(frozen=True, slots=True, kw_only=True)
class Equilibrium:
    displacements_mm: np.ndarray
    """Shape (nodes, 3)."""
    force_n: np.ndarray
    """What holds the nodes, shape (nodes, 3); zero where they move freely."""


def follow_path(
    model: NeoHookeanBoxes | NetworkLattice, moving: sp.csr_matrix, affine_mm: list[np.ndarray]
) -> list[Equilibrium]:
    """Stable equilibria along a path of prescribed displacements.

    Args:
        model: Elements.
        moving: Displacements from reduced unknowns, which are added to the prescribed ones, shape (3 nodes, unknowns).
        affine_mm: Prescribed displacement of all nodes at each step, from rest in equal steps, shape (nodes, 3).
    """
    rest = model.lattice.nodes_mm
    free = before = np.zeros(moving.shape[1])
    pressure = np.zeros(len(model.volumes))
    matrix, path = ReducedMatrix(moving, model.dofs), []
    for affine in affine_mm:
        free, before = 2 * free - before, free  # goes on as it went
        state = model.linearise(rest + affine + (moving @ free).reshape(-1, 3), pressure)
        for iteration in range(40):
            residual = moving.T @ state.gradient
            is_small = np.linalg.norm(residual) < RESIDUAL * np.linalg.norm(state.gradient)
            is_stable = matrix.factorise(state.hessian)
            if iteration and is_small and is_stable:
                break
            if not is_stable:  # the pressure of an early iterate can do that
                pressure = pressure / 2
                state = model.linearise(rest + affine + (moving @ free).reshape(-1, 3), pressure)
                continue
            step = -matrix.solver.solve(residual)
            growth = np.einsum("ca,ca->c", state.volume_gradient, (moving @ step)[model.dofs]) / model.volumes
            change = model.lattice.lame_mpa * (state.dilatation - 1 + growth) - pressure
            part, floor = 2.0, 0.3 * state.min_jacobian
            while part == 2 or state.min_jacobian < floor:
                part /= 2
                assert part > 1e-3, "folded"
                positions = rest + affine + (moving @ (free + part * step)).reshape(-1, 3)
                state = model.linearise(positions, pressure + part * change)
            free, pressure = free + part * step, pressure + part * change
        else:
            raise AssertionError("no stable equilibrium")
        displacements = affine + (moving @ free).reshape(-1, 3)
        path.append(Equilibrium(displacements_mm=displacements, force_n=state.gradient.reshape(-1, 3)))
    return path


def periodic_cell(*, body: tuple[float, float], infill: tuple[float, float], share: float, parts: tuple[int, int]):
    """A unit cell with opposite faces tied and the wall crossing held: elements and map from reduced unknowns.

    Args:
        body: Shear and bulk modulus of the walls [MPa].
        infill: Shear and bulk modulus of the cube in the middle [MPa].
        share: Volume share of the cube.
        parts: Elements across half the cube and across half a wall.
    """
    side = share ** (1 / 3)
    wall, half = (1 - side) / 2 * np.linspace(0, 1, parts[1] + 1)[:-1], _graded_half(1.0, side, parts[0])
    planes = np.concatenate([wall, half, (1 - half[::-1])[1:], 1 - wall[::-1]])
    lattice = box_lattice((planes, planes, planes), shear_modulus_mpa=1, lame_mpa=1)
    soft = (np.abs(lattice.nodes_mm[lattice.cells].mean(1) - 0.5) < side / 2).all(1)
    _fill(lattice, soft, body, infill)
    count = len(planes) - 1
    index = np.stack(np.indices((count + 1,) * 3), -1).reshape(-1, 3) % count
    number = (index[:, 0] * count + index[:, 1]) * count + index[:, 2]
    column = (3 * number[:, None] + np.arange(3)).ravel() - 3
    rows = np.flatnonzero(column >= 0)
    return NeoHookeanBoxes(lattice), sp.csr_matrix(
        (np.ones(len(rows)), (rows, column[rows])), shape=(column.size, 3 * count**3 - 3)
    )


def mean_stress(model: NeoHookeanBoxes, state: Equilibrium) -> np.ndarray:
    """First Piola-Kirchhoff stress from the forces on the boundary, shape (3, 3) [MPa]."""
    return state.force_n.T @ model.lattice.nodes_mm / model.volumes.sum()


def quarter_patch(
    design: ElastomerDesign, grid: CellGrid, *, infill: int, wall: int, skin: int
) -> tuple[NeoHookeanBoxes, sp.csr_matrix, np.ndarray]:
    """The quarter y < 0 and z < height/2 of a printed block.

    Args:
        design: The block.
        grid: Its cells.
        infill: Elements across half an infill cube, finer towards its interface.
        wall: Elements across half a wall.
        skin: Elements across the skin.

    Returns:
        The elements, the map from reduced unknowns to nodal displacements, and which elements are infill.
    """
    planes = [_planes(design, grid, axis, infill, wall, skin) for axis in range(3)]
    planes[1] = planes[1][: len(planes[1]) // 2 + 1]
    planes[2] = planes[2][: len(planes[2]) // 2 + 1]
    lattice = box_lattice((planes[0], planes[1], planes[2]), shear_modulus_mpa=1, lame_mpa=1)
    local = (lattice.nodes_mm[lattice.cells].mean(1) - grid.origin_mm) / grid.pitch_mm
    inside = (local > 0) & (local < grid.counts)
    is_infill = (inside & (np.abs(local % 1 - 0.5) < grid.cell_mm / grid.pitch_mm / 2)).all(1)
    body, soft = design.materials.body, design.materials.infill
    assert soft is not None
    _fill(
        lattice,
        is_infill,
        (body.shear_modulus_mpa, body.bulk_modulus_mpa),
        (soft.shear_modulus_mpa, soft.bulk_modulus_mpa),
    )
    return NeoHookeanBoxes(lattice), _half_turn(lattice), is_infill


def whole_block(lattice: Lattice) -> sp.csr_matrix:
    """Both plates held, everything else free."""
    z = lattice.nodes_mm[:, 2]
    free = np.repeat((z > TOLERANCE_MM) & (z < lattice.height_mm - TOLERANCE_MM), 3)
    return sp.csr_matrix(sp.identity(len(free), format="csc")[:, np.flatnonzero(free)])


def _planes(design: ElastomerDesign, grid: CellGrid, axis: int, infill: int, wall: int, skin: int) -> np.ndarray:
    pitch, cube = grid.pitch_mm[axis], grid.cell_mm[axis]
    low = (pitch - cube) / 2 * np.linspace(0, 1, wall + 1)[:-1]
    half = _graded_half(pitch, cube, infill)
    cell = np.concatenate([low, half, (pitch - half[::-1])[1:], (pitch - low[::-1])[:-1]])
    core = np.concatenate([cell + pitch * number for number in range(grid.counts[axis])])
    edge = design.skin_mm * np.linspace(0, 1, skin + 1)
    size = core[-1] + pitch - cell[-1] + 2 * design.skin_mm
    planes = np.concatenate([edge[:-1], design.skin_mm + core, (size - edge)[::-1]])
    return planes + grid.origin_mm[axis] - design.skin_mm


def _graded_half(pitch: float, cube: float, count: int) -> np.ndarray:
    """Planes from the interface to the middle of the cell, closer at the interface."""
    return pitch / 2 - cube / 2 * (1 - np.linspace(0, 1, count + 1) ** 1.5)


def _fill(lattice: Lattice, is_infill: np.ndarray, body: tuple[float, float], infill: tuple[float, float]) -> None:
    lattice.shear_modulus_mpa[:] = np.where(is_infill, infill[0], body[0])
    lattice.lame_mpa[:] = np.where(is_infill, infill[1], body[1]) - 2 / 3 * lattice.shear_modulus_mpa


def _half_turn(lattice: Lattice) -> sp.csr_matrix:
    """Unknowns of the quarter: lower plate held, y a mirror, the middle plane z mapped to itself by half a turn."""
    nodes, count = lattice.nodes_mm, len(lattice.nodes_mm)
    numbers = np.arange(count).reshape([len(planes) for planes in lattice.planes_mm][::-1])
    partner = np.arange(count)
    partner[numbers[-1]] = numbers[-1][:, ::-1]
    held = np.zeros((count, 3), bool)
    held[nodes[:, 2] < TOLERANCE_MM] = True
    held[nodes[:, 1] > -TOLERANCE_MM, 1] = True
    own = np.flatnonzero(partner == np.arange(count))
    on_axis = own[nodes[own, 2] > nodes[:, 2].max() - TOLERANCE_MM]
    held[on_axis[:, None], [0, 2]] = True
    is_first = (np.arange(count) <= partner)[:, None] & ~held
    column = np.full((count, 3), -1)
    column[is_first] = np.arange(is_first.sum())
    sign = np.ones((count, 3))
    follower = partner < np.arange(count)
    column[follower] = np.where(held[follower], -1, column[partner[follower]])
    sign[follower] = [-1, 1, -1]
    used = column.ravel() >= 0
    rows = np.flatnonzero(used)
    return sp.csr_matrix((sign.ravel()[used], (rows, column.ravel()[used])), shape=(3 * count, is_first.sum()))
