"""How much printed walls lose when they buckle: a periodic block of 2 x 2 x 2 cells against one that cannot.

    python benchmarks/wall_buckling.py          # some minutes a mode; writes docs/benchmarks/wall-buckling.json
    python benchmarks/wall_buckling.py --only shear

Cells of `mini-magictac` with walls of 0.1 mm, walls and infill meshed apart, are squeezed along z at constant volume
as below an indenter, squeezed along z with the sides held (confined), and sheared along x. The block is periodic over
two cells each way; small random forces on the walls stand for what is not perfect in a print. Beside it are cells that
cannot buckle: an eighth of one between its mirrors, which is what the lattice's law of a core cell is made for, and
under shear, where those are none, one periodic cell without imperfection. Both are solved with the same elements, and
the lattice's own law stands beside them for the squeeze. A path ends at the first strain without an equilibrium.
Elements are trilinear with mean dilatation, which makes bending walls up to a quarter too stiff with two of them
across a wall: buckling begins somewhat earlier than found here.
"""

import argparse
import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import contact_face
from magicsim.deform.lattice.cell_problem import cell_fields
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.pattern import BlockPattern, block_pattern
from magicsim.deform.lattice.structure import Lattice, TableTop, box_lattice
from magicsim.deform.solve.factorise import symmetric_solver
from magicsim.geometry.design import ElastomerDesign

Array = npt.NDArray[np.float64]
RESULT = Path(__file__).resolve().parent.parent / "docs" / "benchmarks" / "wall-buckling.json"
STRAINS = {
    "squeeze": (0.1, 0.15, 0.2, 0.225, 0.25, 0.3, 0.4, 0.5),
    "shear": (0.1, 0.2, 0.3, 0.4, 0.5),
    "confined": (0.005, 0.01, 0.02, 0.05, 0.1),
}
"""Squeeze along z, and shear."""
INFILL_PARTS, WALL_PARTS = 6, 2
IMPERFECTION = 5e-3
"""Random force on each node of a wall in units of the walls' shear modulus times the area of an element."""
RESIDUAL, MAX_ITERATIONS, LEAST_PART = 1e-6, 40, 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Periodic cells: elements, and the map from the independent fluctuations to all nodes."""

    elasticity: Elasticity
    pattern: BlockPattern
    tie: sp.csr_matrix
    """Shape (3 nodes, unknowns)."""
    is_infill: npt.NDArray[np.bool_]

    @classmethod
    def of(cls, *, cells: int, share: float, body: tuple[float, float], infill: tuple[float, float]) -> "Block":
        """A cube of cells of unit pitch; moduli are shear and bulk [MPa], the share is that of the infill's volume.

        No cells are the eighth of one between its mirrors.
        """
        side = share ** (1 / 3)
        wall = (1 - side) / 2
        one = np.concatenate(
            [np.linspace(0, wall, WALL_PARTS // 2 + 1)[:-1], np.linspace(wall, 1 - wall, INFILL_PARTS + 1)[:-1],
             np.linspace(1 - wall, 1, WALL_PARTS // 2 + 1)[:-1]],
        )  # fmt: skip
        planes = np.concatenate([*(one + number for number in range(cells)), [float(cells)]])
        if cells == 0:
            planes = np.append(one[one < 0.5 - 1e-9], 0.5)
        lattice = box_lattice((planes, planes, planes), shear_modulus_mpa=1.0, lame_mpa=1.0)
        centre = lattice.nodes_mm[lattice.cells].mean(1) % 1
        is_infill = (np.abs(centre - 0.5) < side / 2).all(1)
        shear = np.where(is_infill, infill[0], body[0])
        lame = np.where(is_infill, infill[1], body[1]) - 2 / 3 * shear
        lattice = replace(lattice, shear_modulus_mpa=shear, lame_mpa=lame)
        loose = replace(lattice, table=TableTop(friction=0.0, weight_mpa=0.0))  # its matrix has all nodes
        pattern = block_pattern(loose, contact_face(lattice).patches)
        return cls(
            elasticity=Elasticity.of(lattice),
            pattern=pattern,
            tie=_tie(lattice) if cells else _mirrors(lattice),
            is_infill=is_infill,
        )

    def hessian(self, positions: Array, pressure: Array) -> sp.csr_matrix:
        """Of all nodes [N/mm]."""
        gradient = self.elasticity.evaluate(positions).volume_gradient
        values = self.elasticity.hessian(positions, pressure, gradient, self.pattern, shift=0.0)
        upper = sp.csr_matrix((values, self.pattern.indices, self.pattern.indptr), shape=(self.pattern.size,) * 2)
        return sp.csr_matrix(upper + sp.triu(upper, 1).T)


def _tie(lattice: Lattice) -> sp.csr_matrix:
    """Opposite faces move alike; the first node is held."""
    count = len(lattice.planes_mm[0]) - 1
    index = np.stack(np.indices((count + 1,) * 3), -1).reshape(-1, 3) % count
    number = (index[:, 0] * count + index[:, 1]) * count + index[:, 2]
    column = (3 * number[:, None] + np.arange(3)).ravel() - 3
    rows = np.flatnonzero(column >= 0)
    return sp.csr_matrix((np.ones(len(rows)), (rows, column[rows])), shape=(column.size, 3 * count**3 - 3))


def _mirrors(lattice: Lattice) -> sp.csr_matrix:
    """Faces stay where the mean motion takes them."""
    size = lattice.planes_mm[0][-1]
    is_free = ~(np.isclose(lattice.nodes_mm, 0) | np.isclose(lattice.nodes_mm, size)).ravel()
    return sp.csr_matrix(sp.identity(is_free.size, format="csc")[:, np.flatnonzero(is_free)])


def motion(mode: str, strain: float) -> Array:
    """Deformation gradient of the block as a whole."""
    if mode == "shear":
        return np.array([[1.0, 0.0, strain], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    across = (1 - strain) ** -0.5 if mode == "squeeze" else 1.0
    return np.diag([across, across, 1 - strain])


def deformed(block: Block, mode: str, *, imperfection: float, seed: int = 0) -> list[dict[str, float]]:
    """Mean stress along the path: that along x less that along z, or the shear stress, and whether it was stable."""
    lattice = block.elasticity.lattice
    rest, random = lattice.nodes_mm, np.random.default_rng(seed)
    wall_nodes = np.unique(lattice.cells[~block.is_infill])
    load = np.zeros_like(rest)
    size = imperfection * lattice.shear_modulus_mpa.max() * (1 / INFILL_PARTS) ** 2
    load[wall_nodes] = size * random.normal(size=(len(wall_nodes), 3))
    pull = block.tie.T @ load.ravel()
    free, pressure, found = np.zeros(block.tie.shape[1]), np.zeros(len(lattice.cells)), []
    solver, kept = None, None
    for strain in STRAINS[mode]:
        affine, shifted = rest @ motion(mode, strain).T, 0
        for _ in range(MAX_ITERATIONS):
            positions = affine + (block.tie @ free).reshape(-1, 3)
            state = block.elasticity.evaluate(positions)
            residual = pull - block.tie.T @ state.gradient.ravel()
            if np.linalg.norm(residual) < RESIDUAL * np.linalg.norm(state.gradient):
                break
            matrix = sp.csr_matrix(sp.triu(block.tie.T @ block.hessian(positions, pressure) @ block.tie))
            matrix.sort_indices()
            if kept is None or not np.array_equal(kept, matrix.indices):
                kept, solver = matrix.indices, symmetric_solver(matrix.indptr, matrix.indices)
            diagonal, shift = matrix.indptr[:-1], 0.0
            while True:
                values = matrix.data.copy()
                values[diagonal] += shift * values[diagonal].max()
                if solver.factorise(values):
                    break
                shift, shifted = max(1e-3, 4 * shift), shifted + 1
            step = solver.solve(residual)
            growth = np.einsum(
                "ca,ca->c", state.volume_gradient,
                (block.tie @ step)[(3 * lattice.cells[:, :, None] + np.arange(3)).reshape(-1, 24)],
            ) / block.elasticity.volumes  # fmt: skip
            target = lattice.lame_mpa * (state.jacobian - 1 + growth)
            part = 1.0
            while part > LEAST_PART:
                trial = affine + (block.tie @ (free + part * step)).reshape(-1, 3)
                if block.elasticity.evaluate(trial).min_jacobian > 0.3 * state.min_jacobian:
                    break
                part /= 2
            free, pressure = free + part * step, pressure + part * (target - pressure)
        else:
            return found
        forces = (state.gradient - load).T @ positions / block.elasticity.volumes.sum()
        stress = float(forces[0, 2] if mode == "shear" else forces[0, 0] - forces[2, 2])
        found.append({"strain": strain, "stress_mpa": stress, "along_z_mpa": float(forces[2, 2]), "shifted": shifted})
        print(mode, found[-1], flush=True)
    return found


def lattice_stress_mpa(strain: float, stiffness: tuple[float, float]) -> float:
    """The same difference by the law of a core cell: mu (network) and beta (walls)."""
    from magicsim.deform.lattice.cell_kernels import wall_energy

    mu, beta = stiffness
    along, across = (1 - strain) ** 2, 1 / (1 - strain)
    rho = mu / (2 * beta)
    walls = [2 * beta * wall_energy(square, rho)[1] * square for square in (across, along)]
    return float(mu * (across - along) + walls[0] - walls[1])


def main() -> None:
    """Solves both blocks and writes the result."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wall", type=float, default=0.1, help="thickness of walls [mm]")
    parser.add_argument("--only", choices=tuple(STRAINS), help="one mode; the others are kept")
    parser.add_argument("--out", type=Path, default=RESULT)
    options = parser.parse_args()
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [f"wall_mm={options.wall}", "skin_mm=0.5"])
    body, infill = design.materials.body, design.materials.infill
    assert infill is not None
    moduli = {
        "body": (body.shear_modulus_mpa, body.bulk_modulus_mpa),
        "infill": (infill.shear_modulus_mpa, infill.bulk_modulus_mpa),
    }
    share = (design.cell_mm / (design.cell_mm + design.wall_mm)) ** 3
    cell = cell_fields(**moduli, infill_share=share).stiffness
    for mode in [options.only] if options.only else list(STRAINS):
        perfect = Block.of(cells=1 if mode == "shear" else 0, share=share, **moduli)
        straight = deformed(perfect, mode, imperfection=0.0)
        buckled = deformed(Block.of(cells=2, share=share, **moduli), mode, imperfection=IMPERFECTION)
        rows = [
            {"strain": one["strain"], "straight_mpa": one["stress_mpa"], "buckled_mpa": two["stress_mpa"],
             "straight_along_z_mpa": one["along_z_mpa"], "buckled_along_z_mpa": two["along_z_mpa"]}
            for one, two in zip(straight, buckled, strict=False)
        ]  # fmt: skip
        if mode == "squeeze":
            law = (cell.shear_modulus_mpa, cell.wall_modulus_mpa)
            rows = [row | {"lattice_mpa": lattice_stress_mpa(row["strain"], law)} for row in rows]
        reached = {"straight": straight[-1]["strain"], "buckled": buckled[-1]["strain"]}
        kept = json.loads(options.out.read_text()) if options.out.is_file() else {}
        modes = kept.get("modes", {}) | {mode: {"reached": reached, "rows": rows}}
        found = {"wall_mm": options.wall, "moduli_mpa": moduli, "modes": modes}
        options.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
