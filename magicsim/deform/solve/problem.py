"""The problem that a Newton iteration solves, and when it stops: nothing here changes along a path."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array
from magicsim.deform.contact.face import ContactFace, contact_face
from magicsim.deform.contact.friction import ContactLaw
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.pattern import BlockPattern, block_pattern
from magicsim.deform.lattice.relaxation import Branches
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.table import TableMemory
from magicsim.deform.quality import NewtonOptions
from magicsim.deform.solve.factorise import SymmetricSolver, symmetric_solver

EPS = float(np.finfo(np.float64).eps)
ROUNDINGS = 4
"""Relative error of a cell's forces before they cancel, in units of that of one number."""
MORE_ITERATIONS = 2
"""Iterations of a load step in units of `NewtonOptions.max_iterations`: assumed."""
MOST_CONTRAST = 3e3
"""Largest over smallest modulus up to which factors are of single precision: assumed."""
CLOSE = 1e-6
"""Residual up to which factors are of double precision below an object with edges: points there may lie on either side
of an edge, and the rounding of single precision would decide on which."""
FORCE_FLOOR = 1e-2
"""Contact forces below this, in units of shear modulus times smallest edge squared, do not sharpen the residual:
assumed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """A lattice, its contact face and its solver."""

    elasticity: Elasticity
    face: ContactFace
    pattern: BlockPattern
    """Pattern of the matrix with contact."""
    body_pattern: BlockPattern
    """Pattern of the body's own matrix: sparser, since contact couples nodes of a face that share no cell."""
    solver: SymmetricSolver
    options: NewtonOptions
    law: ContactLaw
    stiffness: float
    """Instantaneous Young's modulus of the skin (nu = 1/2) over the smallest cell edge [N/mm3]."""
    least_force_n: float
    """Contact forces below this do not sharpen the residual: they are small for the lattice, or its own rounding would
    exceed the tolerance [N]."""

    @classmethod
    def of(
        cls,
        lattice: Lattice,
        options: NewtonOptions,
        *,
        friction: float,
        point_spacing_mm: float,
        branches: Branches | None,
    ) -> Self:
        """A problem with the penalties that fit its lattice; its elasticity is that of the long term."""
        face = contact_face(lattice, point_spacing_mm=point_spacing_mm)
        pattern = block_pattern(lattice, face.patches)
        edge_mm = lattice.smallest_edge_mm
        shear_mpa = lattice.shear_modulus_mpa + (0.0 if branches is None else branches.shear_modulus_mpa.sum(0))
        stiffness = 3 * float(shear_mpa[: len(face.patches)].max()) / edge_mm
        floor = FORCE_FLOOR * float(lattice.shear_modulus_mpa.max()) * edge_mm**2
        return cls(
            elasticity=Elasticity.of(lattice),
            face=face,
            pattern=pattern,
            body_pattern=block_pattern(lattice),
            solver=symmetric_solver(pattern.indptr, pattern.indices),
            options=options,
            law=ContactLaw(
                slip_penalty=options.slip_penalty_ratio * stiffness,
                elastic_slip_mm=options.elastic_slip_ratio * edge_mm,
                friction=friction,
            ),
            stiffness=stiffness,
            least_force_n=max(floor, _rounding_n(lattice, shear_mpa) / options.residual),
        )

    def with_care(self) -> Self:
        """This problem for a load step after one that failed: friction limits wait for balance, no factor is kept."""
        most = MORE_ITERATIONS * self.options.max_iterations
        return replace(self, options=replace(self.options, patience=0, max_iterations=most, keeps_factors=False))

    def on_table(self, memory: TableMemory | None) -> Self:
        """This problem with the base as an earlier load step has left it; itself where the base is bonded."""
        table = self.elasticity.table
        if table is None or memory is None:
            return self
        return replace(self, elasticity=replace(self.elasticity, table=replace(table, memory=memory)))

    def with_table_at(self, positions: Array) -> Self:
        """This problem with limits of friction below the block that belong to an equilibrium, shape (nodes, 3) [mm]."""
        table = self.elasticity.table
        return self if table is None else self.on_table(table.updated(positions))

    def free_forces(self, forces_n: Array) -> Array:
        """Forces that can move the nodes: those along held displacements are zero, shape (free nodes, 3) [N]."""
        return np.asarray(forces_n[: len(self.pattern.held) // 3] * ~self.pattern.held.reshape(-1, 3))

    @property
    def is_well_conditioned(self) -> bool:
        """Whether a factor of single precision is good enough to iterate with."""
        lattice = self.elasticity.lattice
        stiffest = max(lattice.lame_mpa.max(), lattice.coat_n_per_mm / lattice.smallest_edge_mm)
        return bool(stiffest < MOST_CONTRAST * lattice.shear_modulus_mpa.min()) and not self.is_at_edges

    @property
    def is_at_edges(self) -> bool:
        """Whether what touches has edges, and equilibria are solved so closely that their sides count."""
        zone = self.elasticity.lattice.zone
        return zone is not None and zone.edges is not None and self.options.residual <= CLOSE

    @property
    def cautious(self) -> float:
        """Largest pressure times curvature of the object that counts far from balance [N/mm3]: assumed."""
        return self.stiffness / 4

    @property
    def first_penalty(self) -> float:
        """Stiffness of contact along the normal that a load step begins with [N/mm3]."""
        return self.options.penalty_ratio * self.stiffness


def _rounding_n(lattice: Lattice, shear_modulus_mpa: Array) -> float:
    """Rounding of the out-of-balance forces [N].

    Spring forces cancel those of the logarithm, and the rounding of a volume is multiplied by lambda: that of the
    cell's own numbers, or of its nodes' positions where the cell is small for its distance from the origin.
    """
    areas = np.sort(lattice.sizes_mm, axis=1)[:, 1:].prod(1)
    distance = np.abs(lattice.nodes_mm[lattice.cells]).max(1) / lattice.sizes_mm
    forces = (lattice.lame_mpa + shear_modulus_mpa) * areas * np.maximum(ROUNDINGS, distance.max(1))
    return EPS * float(np.linalg.norm(forces))
