"""A base that lies loose on a rigid table: unilateral contact with Coulomb friction at the nodes of that plane.

The table presses up on a node with p = max(0, w + e (z - height)) for each area, w the weight of the block over its
footprint. The weight itself acts down on the same nodes, so that the block at rest is undeformed, lifts off against
its weight alone, and is held sideways before anything presses. The lumped areas are exact for an even pressure.

Friction is that of `friction`: a node hangs on an anchor on the table, and its traction is cut at a limit, mu p, which
is frozen during the iterations; energy and matrix then belong together and stay symmetric. `Table.updated` brings
limits up to date where an equilibrium is found; anchors follow where a load step ends.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from magicsim.arrays import Array, Indices
from magicsim.deform.lattice.structure import Lattice

PENALTY_RATIO = 300.0
"""Stiffness of table and sticking nodes in units of Young's modulus (nu = 1/2) over the height of the lowest cells: at
half a megapascal a node sinks in by a thousandth of a millimetre."""
ELASTIC_SLIP_RATIO = 2e-3
"""Motion of a sticking node up to its limit, in units of the same height: assumed."""
MISMATCH = 2e-3
"""Largest departure from the law of friction, see `TableState.mismatch`: assumed."""
TINY = 1e-300


@dataclass(frozen=True, slots=True, kw_only=True)
class TableMemory:
    """Memory of friction at the nodes of the base."""

    anchors_mm: Array
    """Where it holds them, x and y, shape (base nodes, 2) [mm]."""
    limit_mpa: Array
    """Frozen limit of the tangential traction, shape (base nodes,) [MPa]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The plane below a lattice; its law with frozen limits has a potential."""

    first: int
    """Number of the first node of the base; all others follow."""
    height_mm: float
    """Where the table lies [mm]."""
    area_mm2: Array
    """Area of the nodes of the base, shape (base nodes,) [mm2]."""
    friction: float
    """Coulomb's coefficient."""
    weight_mpa: float
    """Weight of the block over its footprint [MPa]."""
    stiffness: float
    """Stiffness of the table, and largest one of a sticking node [N/mm3]."""
    elastic_slip_mm: float
    """Least motion of a sticking node on the way to its limit [mm]."""
    memory: TableMemory

    @classmethod
    def below(cls, lattice: Lattice) -> Self | None:
        """The table of a lattice at rest; None where its base is bonded."""
        if lattice.table is None:
            return None
        x, y, z = lattice.planes_mm
        first = len(lattice.nodes_mm) - lattice.layer_nodes
        above = lattice.shear_modulus_mpa[-(len(x) - 1) * (len(y) - 1) :]
        height = float(z[-1] - z[-2])
        weight, friction = lattice.table.weight_mpa, lattice.table.friction
        memory = TableMemory(
            anchors_mm=lattice.nodes_mm[first:, :2], limit_mpa=np.full(lattice.layer_nodes, friction * weight)
        )
        return cls(
            first=first,
            height_mm=lattice.height_mm,
            area_mm2=np.outer(_shares_mm(y), _shares_mm(x)).ravel(),
            friction=friction,
            weight_mpa=weight,
            stiffness=PENALTY_RATIO * 3 * float(above.max()) / height,
            elastic_slip_mm=ELASTIC_SLIP_RATIO * height,
            memory=memory,
        )

    def evaluate(self, positions: Array) -> "TableState":
        """Forces at node positions, shape (nodes, 3) [mm], their potential, and the memory if a load step ends here."""
        slip, size, amount = self._slip(positions)
        stick = np.maximum(self._stick(), TINY)
        along = (amount / np.maximum(size, TINY))[:, None] * slip
        depth = positions[self.first :, 2] - self.height_mm
        pressure = self._pressure_mpa(positions)
        pressed = (pressure**2 - self.weight_mpa**2) / (2 * self.stiffness) - self.weight_mpa * depth
        slipped = amount * size - amount**2 / (2 * stick)
        limit = self.friction * pressure
        total = float(self.area_mm2 @ limit)
        off = float(self.area_mm2 @ np.abs(limit - self.memory.limit_mpa))
        return TableState(
            node_force_n=self.area_mm2[:, None] * np.column_stack([-along, self.weight_mpa - pressure]),
            energy_mj=float(self.area_mm2 @ (pressed + slipped)),
            memory=replace(self.memory, anchors_mm=positions[self.first :, :2] - along / stick[:, None]),
            mismatch=off / total if total > 0 else 0.0,
        )

    def updated(self, positions: Array) -> TableMemory:
        """Memory with the limits of friction that belong to an equilibrium, positions of shape (nodes, 3) [mm]."""
        return replace(self.memory, limit_mpa=self.friction * self._pressure_mpa(positions))

    def add_stiffness(self, positions: Array, indptr: Indices, values: Array) -> None:
        """Adds the derivative of the forces, its sign changed, to an upper triangle in 3 x 3 blocks, in place."""
        slip, size, amount = self._slip(positions)
        stick = self._stick()
        slides = stick * size >= self.memory.limit_mpa
        along = np.where(slides, 1 / np.maximum(size, TINY), 0.0)[:, None] * slip
        secant = self.area_mm2 * np.where(slides, amount / np.maximum(size, TINY), stick)
        x = indptr[3 * np.arange(self.first, self.first + len(slip))]
        y, z = (indptr[3 * np.arange(self.first, self.first + len(slip)) + axis] for axis in (1, 2))
        values[x] += secant * (1 - along[:, 0] ** 2)
        values[x + 1] -= secant * along[:, 0] * along[:, 1]
        values[y] += secant * (1 - along[:, 1] ** 2)
        values[z] += self.area_mm2 * np.where(self._pressure_mpa(positions) > 0, self.stiffness, 0.0)

    def _pressure_mpa(self, positions: Array) -> Array:
        """Pressure of the table on the nodes of the base, shape (base nodes,) [MPa]."""
        depth = positions[self.first :, 2] - self.height_mm
        return np.asarray(np.maximum(0.0, self.weight_mpa + self.stiffness * depth))

    def _stick(self) -> Array:
        """Stiffness of each node as long as it sticks, shape (base nodes,) [N/mm3]."""
        return np.minimum(self.stiffness, self.memory.limit_mpa / self.elastic_slip_mm)

    def _slip(self, positions: Array) -> tuple[Array, Array, Array]:
        """Offset from the anchors, shape (base nodes, 2) [mm], its length [mm], and the traction [MPa]."""
        slip = positions[self.first :, :2] - self.memory.anchors_mm
        size = np.linalg.norm(slip, axis=1)
        return slip, size, np.minimum(self._stick() * size, self.memory.limit_mpa)


@dataclass(frozen=True, slots=True, kw_only=True)
class TableState:
    """Forces of a table on the base at given positions."""

    node_force_n: Array
    """Force of table and weight on the nodes of the base, shape (base nodes, 3) [N]."""
    energy_mj: float
    """From which the forces derive, zero at rest [N mm]."""
    memory: TableMemory
    """At the end of a load step that ends here: a sliding node drags its anchor, a lifted one has it below itself."""
    mismatch: float
    """How far the frozen limits are from mu times the pressure: sum of the forces over the largest friction."""


def has_settled(table: TableState | None) -> bool:
    """Whether the limits of friction below the block are those of its pressures; always where the base is bonded."""
    return table is None or table.mismatch <= MISMATCH


def _shares_mm(planes_mm: Array) -> Array:
    """Length that each plane stands for, shape (planes,) [mm]."""
    half = np.diff(planes_mm) / 2
    return np.concatenate([half[:1], half[1:] + half[:-1], half[-1:]])
