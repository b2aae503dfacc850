"""A core that fails: walls that buckle, walls that tear, infill that flows, and what a block remembers of it.

Each of the three is left out unless its number is given. Buckled walls are elastic (`cell_kernels`): they only change
the lattice. Torn walls (`tearing`) and an infill that has flowed (`yielding`) are memory: earlier touches matter, and
energy becomes heat. While an infill flows that heat is its own, tau : (1 - s) e'. When walls tear, nothing moves the
object, so that all that the block stores less at its next equilibrium is heat; it is never negative, since walls that
go take energy away at a fixed deformation, and the way from there to equilibrium takes more.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Index
from magicsim.config.ranges import check_number
from magicsim.deform.lattice.energy import Elasticity
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.lattice.tearing import TearLaw
from magicsim.deform.lattice.yielding import FlowLaw
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.limits import CoreFailure

SETTLED = 1e-3
"""Change of a metric, 1 at rest, that counts as none: assumed."""
LEAST_SQUEEZE, MOST_SQUEEZE = 0.01, 0.35
"""Squeezes at which walls may buckle; those of `mini-magictac` are bounded at the second one anyway."""


def weakened(lattice: Lattice, failure: CoreFailure) -> Lattice:
    """A lattice whose walls buckle; itself where they do not.

    Raises:
        ConfigError: The strain is out of its range, or the block has no walls.
    """
    strain = failure.wall_buckling_strain
    if strain is None:
        return lattice
    check_number("wall_buckling_strain", strain, LEAST_SQUEEZE, MOST_SQUEEZE)
    if lattice.grid is None:
        raise ConfigError(f"wall_buckling_strain = {strain:g} is not allowed for a block without walls (cell_mm = 0)")
    return replace(lattice, wall_buckling_strain=strain)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreLaw:
    """What of a lattice's core flows and tears; at least one of both."""

    flow: FlowLaw | None = None
    tear: TearLaw | None = None

    @classmethod
    def of(cls, design: ElastomerDesign, lattice: Lattice, failure: CoreFailure) -> Self | None:
        """The laws of a design's lattice; None where nothing is remembered.

        Raises:
            ConfigError: A number is out of its range, or the block has no infill or no walls.
        """
        flow = FlowLaw.of(design, lattice, failure.infill_yield_mpa)
        tear = TearLaw.of(design, lattice, failure.wall_tear_elongation)
        return None if flow is None and tear is None else cls(flow=flow, tear=tear)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreState:
    """Memory of a core that fails."""

    tensors: Array
    """A of the infill at the Gauss points of the cells that can flow, shape (cells, 8, 3, 3)."""
    torn: Array
    """Share of the walls of each printed cell that is torn, 0 or 1 at an equilibrium, shape (printed cells,)."""
    dissipated_nmm: float
    """Energy that has become heat since the path began [N mm]."""

    @property
    def has_failed(self) -> bool:
        """Whether infill has flowed or walls have torn."""
        return self.dissipated_nmm > 0 or bool(self.torn.any())


@dataclass(frozen=True, slots=True, kw_only=True)
class FailingCore:
    """A lattice whose core can fail."""

    elasticity: Elasticity
    """The lattice at rest."""
    law: CoreLaw

    def rest(self) -> CoreState:
        """A core that has neither flowed nor torn."""
        flow, tear = self.law.flow, self.law.tear
        return CoreState(
            tensors=flow.rest() if flow is not None else np.empty((0, 8, 3, 3)),
            torn=tear.whole() if tear is not None else np.zeros(0),
            dissipated_nmm=0.0,
        )

    def at(self, state: CoreState) -> Elasticity:
        """The energy of the lattice with its core as it has failed; that of rest where it has not."""
        elasticity, flow, tear = self.elasticity, self.law.flow, self.law.tear
        if not state.has_failed:
            return elasticity
        if tear is not None:
            elasticity = tear.left(elasticity, state.torn)
        return flow.flowed(elasticity, state.tensors) if flow is not None else elasticity

    def flowed(self, state: CoreState, positions: Array) -> CoreState:
        """The core after its infill has followed a step from a state to node positions, shape (nodes, 3) [mm]."""
        if self.law.flow is None:
            return state
        left = self.law.tear.left(self.elasticity, state.torn) if self.law.tear is not None else self.elasticity
        tensors, heat = self.law.flow.advanced(left, state.tensors, positions)
        return replace(state, tensors=tensors, dissipated_nmm=state.dissipated_nmm + heat)

    def unsettled(self, last: CoreState, now: CoreState) -> float:
        """Share of the volume that can flow whose metric differs between two states by more than `SETTLED`."""
        if self.law.flow is None:
            return 0.0
        weights = self.elasticity.weights[self.law.flow.cells]
        moved = np.abs(now.tensors - last.tensors).max((2, 3)) > SETTLED
        return float(weights[moved].sum() / weights.sum())

    def next_torn(self, state: CoreState, positions: Array) -> Index:
        """Printed cells whose walls tear next at an equilibrium, nodes of shape (nodes, 3) [mm]; none if all hold."""
        if self.law.tear is None:
            return np.empty(0, np.int64)
        return self.law.tear.next(self.elasticity, state.torn, positions)

    def stored_nmm(self, state: CoreState, positions: Array) -> float:
        """Energy that a state keeps at node positions, shape (nodes, 3) [N mm]."""
        found = self.at(state).evaluate(positions)
        volume = self.elasticity.lattice.lame_mpa * self.elasticity.volumes * (found.jacobian - 1) ** 2
        return found.energy_mj + float(volume.sum()) / 2
