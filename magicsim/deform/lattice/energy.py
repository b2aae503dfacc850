"""Energy, gradient and Hessian of the lattice.

    W = sum_springs k/2 |x_i - x_j|^2 - sum_cells mu V0 <ln J> + sum_cells lambda/2 V0 (Jbar - 1)^2 + walls + coat

The network springs have no rest length (the structural springs of printed walls, in `cell_kernels`, have one). J is the
Jacobian at the 2 x 2 x 2 Gauss points and Jbar their mean, which is the exact trilinear volume over V0 (the Jacobian is
quadratic in each coordinate, so two points a direction integrate it). The pressure term is no stabiliser: a Gaussian
network alone has no elastic constants and would collapse. For affine motion and no walls W is the compressible neo-
Hookean solid mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2 (Bonet and Wood 2008, 6.4.3, with that volume term).
"""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Thread

import numba as nb
import numpy as np

from magicsim.arrays import Array, Index, Mask
from magicsim.deform.lattice.cell_kernels import FOLLOWED, add_stiffness, evaluate_cells
from magicsim.deform.lattice.hexahedron import CORNERS, EDGES, gauss_geometry, network_matrices, spring_matrices
from magicsim.deform.lattice.membrane import Membrane
from magicsim.deform.lattice.pattern import BlockPattern
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import Table, TableState

TINY = 1e-300
BOX_SLACK_MM = 1e-9
"""Largest deviation of a corner in a cell that counts as a box [mm]."""
SLENDER = 1.5
"""Ratio of edges from which a box takes its springs from the Gauss points: edge and face springs of long cells are too
stiff, which costs a graded lattice two thirds of its accuracy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ElasticState:
    """Energy of the lattice at given positions, and its derivatives."""

    energy_mj: float
    """Springs, logarithm, walls, coat and table, without the volume term, zero at rest [N mm]."""
    gradient: Array
    """Gradient of the whole energy, the volume term included, shape (nodes, 3) [N]."""
    jacobian: Array
    """Volume over rest volume of each cell, shape (cells,)."""
    volume_gradient: Array
    """Gradient of each cell's volume, shape (cells, 24) [mm2]."""
    min_jacobian: float
    """Smallest Jacobian at any Gauss point."""
    table: TableState | None
    """State of the table below the base; None where it is bonded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Elasticity:
    """The lattice as the kernels want it."""

    lattice: Lattice
    volumes: Array
    """Rest volume of each cell, shape (cells,) [mm3]."""
    inverse: Array
    """Inverse Jacobian of the rest map at the Gauss points, shape (cells, 8, 3, 3) [1/mm]."""
    weights: Array
    """Rest volume of each Gauss point, shape (cells, 8) [mm3]."""
    springs: Array
    """Laplacian of the network springs, shape (cells, 8, 8) [N/mm]."""
    log_modulus_mpa: Array
    """Factor of -ln J: the shear modulus, shape (cells,) [MPa]."""
    walls: Array
    """Stiffness beta V / 4 of the structural springs of each cell, shape (cells,) [N mm]."""
    wall_ratio: Array
    """Where the law of each cell's walls is bounded: mu / 2 beta (`cell_kernels`), or less where walls buckle, shape
    (cells,)."""
    edges_mm: Array
    """Rest length of the edges, shape (cells, 12) [mm]."""
    table: Table | None = None
    """Table below the base; None where it is bonded."""
    coat: Membrane | None = None
    """The coat on the contact face; None where there is none, or it has no stiffness."""

    @classmethod
    def of(cls, lattice: Lattice) -> "Elasticity":
        """Prepares a lattice."""
        corners = lattice.nodes_mm[lattice.cells]
        inverse, weights = gauss_geometry(corners)
        springs = spring_matrices(lattice.sizes_mm, lattice.shear_modulus_mpa)
        bent = ~_have_spring_weights(corners, lattice.sizes_mm)
        network = network_matrices(inverse[bent], weights[bent], lattice.shear_modulus_mpa[bent])
        if lattice.face is not None:
            boxes = lattice.sizes_mm[bent][:, None] * CORNERS
            stubby = _have_spring_weights(boxes, lattice.sizes_mm[bent])
            network[stubby] += bending_springs(
                boxes[stubby], corners[bent][stubby], springs[bent][stubby], lattice.shear_modulus_mpa[bent][stubby]
            )
        springs[bent] = network
        volumes = weights.sum(1)
        ratio = lattice.shear_modulus_mpa / np.maximum(2 * lattice.wall_modulus_mpa, TINY)
        if (strain := lattice.wall_buckling_strain) is not None:
            ratio = np.minimum(ratio, ((1 - strain) ** -2 - 1) / (2 * FOLLOWED))
        return cls(
            lattice=lattice,
            volumes=volumes,
            inverse=inverse,
            weights=weights,
            springs=springs,
            log_modulus_mpa=lattice.shear_modulus_mpa,
            walls=lattice.wall_modulus_mpa * volumes / 4,
            wall_ratio=ratio,
            edges_mm=np.linalg.norm(corners[:, EDGES[:, 1]] - corners[:, EDGES[:, 0]], axis=2),
            table=Table.below(lattice),
            coat=Membrane.on(lattice),
        )

    def evaluate(self, positions: Array) -> ElasticState:
        """Energy, gradient and Jacobians at node positions of shape (nodes, 3) [mm]."""
        lattice = self.lattice
        count = len(lattice.cells)
        energy, jacobian, volume_gradient = np.empty(count), np.empty(count), np.empty((count, 24))
        gradients, smallest = np.zeros((2, *positions.shape)), np.empty(2)

        def evaluate(half: slice) -> None:
            number = int(half.start > 0)
            smallest[number] = evaluate_cells(
                positions, lattice.cells[half], self.weights[half], self.log_modulus_mpa[half], lattice.lame_mpa[half],
                self.springs[half], self.walls[half], self.wall_ratio[half], self.edges_mm[half], energy[half],
                jacobian[half], volume_gradient[half], gradients[number],
            )  # fmt: skip

        in_halves(evaluate, count)
        gradient, total = gradients.sum(0), float(energy.sum())
        below = None
        if self.table is not None:
            below = self.table.evaluate(positions)
            gradient[self.table.first :] -= below.node_force_n
            total += below.energy_mj
        if self.coat is not None:
            total += self.coat.evaluate(positions, gradient)
        return ElasticState(
            energy_mj=total,
            gradient=gradient,
            jacobian=jacobian,
            volume_gradient=volume_gradient,
            min_jacobian=float(smallest.min()),
            table=below,
        )

    def hessian(
        self, positions: Array, pressure: Array, volume_gradient: Array, pattern: BlockPattern, *, shift: float
    ) -> Array:
        """Upper triangle of the Hessian of the free nodes [N/mm], pressure condensed out, and a multiple of springs."""
        lattice = self.lattice
        halves = np.zeros((2, len(pattern.indices)))
        bulk, springs = lattice.lame_mpa / self.volumes, self.springs * (1 + shift)

        def add(half: slice) -> None:
            add_stiffness(
                positions, lattice.cells[half], self.weights[half], self.log_modulus_mpa[half], bulk[half],
                pressure[half], springs[half], self.walls[half], self.wall_ratio[half], self.edges_mm[half],
                volume_gradient[half], pattern.indptr, pattern.blocks[half], halves[int(half.start > 0)],
            )  # fmt: skip

        in_halves(add, len(lattice.cells))
        values: Array = halves[0]
        values += halves[1]
        if self.table is not None:
            self.table.add_stiffness(positions, pattern.indptr, values)
        if self.coat is not None:
            self.coat.add_stiffness(positions, pattern, values, shift=shift)
        return values


def bending_springs(boxes_mm: Array, corners_mm: Array, springs: Array, modulus_mpa: Array) -> Array:
    """Springs of boxes less their network, where the boxes are mapped to other cells, shape (cells, 8, 8).

    Springs and network of a box differ only in how they hold motions that are not affine. That difference is taken
    along, less its part that an affine motion of the mapped cell would feel: rest stays free of stress, the patch test
    holds, and a cell that is a box again has its springs. Corners are of shape (cells, 8, 3).
    """
    difference = springs - network_matrices(*gauss_geometry(boxes_mm), modulus_mpa)
    centred = corners_mm - corners_mm.mean(1, keepdims=True)
    affine, _ = np.linalg.qr(np.concatenate([np.ones((len(corners_mm), 8, 1)), centred], 2))
    rest = np.eye(8) - affine @ affine.transpose(0, 2, 1)
    return np.asarray(rest @ difference @ rest)


def _have_spring_weights(corners_mm: Array, sizes_mm: Array) -> Mask:
    """Whether cells are boxes along the axes that are not too long for the weights of springs, shape (cells,)."""
    offset = corners_mm - corners_mm[:, :1] - CORNERS * sizes_mm[:, None]
    is_box = (np.abs(offset) < BOX_SLACK_MM).all((1, 2))
    return np.asarray(is_box & (sizes_mm.max(1) < SLENDER * sizes_mm.min(1)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Linearisation:
    """Where a body's stiffness was taken, and the part of the face that it was condensed onto."""

    elasticity: Elasticity
    """Energy of the body; it changes with every step of a path that takes time."""
    positions: Array
    """Positions of the nodes, shape (nodes, 3) [mm]."""
    pressure: Array
    """Volumetric stress of each cell, shape (cells,) [MPa]."""
    volume_gradient: Array
    """Gradient of each cell's volume there, shape (cells, 24) [mm2]."""
    shift: float
    """Multiple of the spring Laplacian that was added."""
    facets: Index
    """Facets of the face, ascending."""


FEWEST_CELLS = 1000
"""Cells below which a second thread costs more than it saves."""


def in_halves(work: Callable[[slice], None], count: int) -> None:
    """Calls a function that lets go of the interpreter's lock for each half of some cells, by two threads if there are.

    Sums over cells are always taken half by half, so that results do not depend on how many threads there are. The
    function writes nothing that the other half reads or writes, and does not raise.
    """
    first, second = slice(0, count // 2), slice(count // 2, count)
    may_use_two = nb.config.NUMBA_NUM_THREADS > 1  # type: ignore[attr-defined]
    if count < FEWEST_CELLS or not may_use_two:
        work(first)
        work(second)
        return
    other = Thread(target=work, args=(second,))
    other.start()
    work(first)
    other.join()
