"""The one factor that a solver holds.

What a solve comes to depends on its path alone: a factor is a function of its `Linearisation`, which the states of a
path carry, and is made again where the solver holds another one.
"""

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.deform.lattice.energy import Linearisation
from magicsim.deform.solve.face_part import FacePart
from magicsim.deform.solve.factorise import SymmetricCondenser, symmetric_condenser
from magicsim.deform.solve.problem import Problem

MAX_UNKNOWNS = 3000
"""Largest dense problem; beyond it factorisations of the whole lattice are as cheap."""


class FactorStore:
    """Holds one factor; that of another linearisation replaces it, the analysis of the same facets is kept."""

    def __init__(self) -> None:
        """Starts without one."""
        self._held: Linearisation | None = None
        self._part: FacePart | None = None
        self._condenser: SymmetricCondenser | None = None
        self._stiffness: Array = np.empty((0, 0))
        self.made = 0
        """Factorisations so far."""

    def part(self, problem: Problem, facets: Index) -> FacePart | None:
        """Some facets with the analysis of what is condensed onto them; None where there are none, or too many.

        Args:
            problem: The lattice.
            facets: Ascending.
        """
        if self._part is not None and np.array_equal(self._part.facets, facets):
            return self._part
        part = FacePart.of(problem.face, facets)
        if len(facets) == 0 or len(part.unknowns) > MAX_UNKNOWNS:
            return None
        pattern = problem.body_pattern
        self._held, self._part = None, part
        self._condenser = symmetric_condenser(
            pattern.indptr, pattern.indices, part.unknowns, is_single=problem.is_well_conditioned
        )
        return part

    def factor(
        self, problem: Problem, linearisation: Linearisation
    ) -> tuple[FacePart, SymmetricCondenser, Array] | None:
        """Part of the face, factor and Schur complement of a linearisation; None where its interior is not definite.

        Args:
            problem: The lattice.
            linearisation: Of the same lattice; its facets are some, and not too many.
        """
        part = self.part(problem, linearisation.facets)
        if part is None or self._condenser is None:
            return None
        if linearisation is not self._held:
            values = linearisation.elasticity.hessian(
                linearisation.positions, linearisation.pressure, linearisation.volume_gradient, problem.body_pattern,
                shift=linearisation.shift,
            )  # fmt: skip
            problem.body_pattern.hold(values)
            found = self._condenser.factorise(values)
            self.made += 1
            self._held = None if found is None else linearisation
            if found is None:
                return None
            self._stiffness = found
        return part, self._condenser, self._stiffness
