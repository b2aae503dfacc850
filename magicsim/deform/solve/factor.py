"""The one factor that a solver holds, and how a path knows when a new one is due.

What a solve comes to depends on its path alone: a factor is a function of its `Linearisation`, which the states of a
path carry, and is made again where the solver holds another one.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.deform.linear.factorise import SymmetricCondenser, symmetric_condenser
from magicsim.deform.solve.body import Linearisation
from magicsim.deform.solve.face_part import FacePart
from magicsim.deform.solve.problem import Problem

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
MAX_UNKNOWNS = 3000
"""Largest dense problem; beyond it factorisations of the whole lattice are as cheap."""
LONGER = 1.3
"""Factor of the way that a factor is expected to serve, each time that this way is over, so that a longer one is tried
now and then."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Carried:
    """What a path hands from state to state to save factorisations."""

    linearisation: Linearisation | None
    """That of the last state; None where it serves no longer."""
    moved_mm: float = 0.0
    """Way of the object since then [mm]."""
    serves_mm: float = np.inf
    """Way after which it is expected to serve no longer: the one on which a factor has failed last [mm]."""

    def moved(self, way_mm: float) -> "Carried":
        """For a load step of some length."""
        moved = self.moved_mm + way_mm
        if moved > self.serves_mm:
            return Carried(linearisation=None, serves_mm=LONGER * self.serves_mm)
        return replace(self, moved_mm=moved)

    def failed(self) -> "Carried":
        """Where it has turned out that it serves no longer."""
        return Carried(linearisation=None, serves_mm=self.moved_mm if self.moved_mm > 0 else self.serves_mm)

    def made(self, linearisation: Linearisation) -> "Carried":
        """Where a new one was made in the present load step."""
        return Carried(linearisation=linearisation, serves_mm=self.serves_mm)


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

    def holds(self, linearisation: Linearisation | None) -> bool:
        """Whether the factor of this very linearisation is the one that is held."""
        return linearisation is not None and linearisation is self._held

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
        pattern = problem.pattern
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
            elasticity, positions = linearisation.elasticity, linearisation.positions
            values = elasticity.hessian(
                positions, linearisation.pressure, elasticity.evaluate(positions).volume_gradient, problem.pattern,
                shift=linearisation.shift,
            )  # fmt: skip
            problem.pattern.hold(values)
            found = self._condenser.factorise(values)
            self.made += 1
            self._held = None if found is None else linearisation
            if found is None:
                return None
            self._stiffness = found
        return part, self._condenser, self._stiffness
