"""Bubbles and flakes of a block on the renderer's side, which follow the mesh of its cells."""

from typing import Any, Self

import numpy as np

from magicsim.arrays import Array
from magicsim.geometry.elastomer import Elastomer
from magicsim.geometry.placed_inclusions import DrawnInclusions
from magicsim.light.backend import mi
from magicsim.light.flaws.scatterers import Scatterers


class HeldScatterers:
    """Those of one print, computed once for each state of its mesh."""

    def __init__(self, drawn: DrawnInclusions, infill_ior: float, reflectance: float) -> None:
        """Takes what was drawn.

        Args:
            drawn: Of the print.
            infill_ior: Index of its infill.
            reflectance: Of its flakes.
        """
        self._drawn, self._optics = drawn, (infill_ior, reflectance)
        self._positions: Any = None
        self._state: tuple[Scatterers, Array] | None = None

    @classmethod
    def of(cls, elastomer: Elastomer) -> Self | None:
        """Those of a block, or None where its print is clean."""
        drawn, infill = elastomer.inclusions, elastomer.design.materials.infill
        if drawn is None or infill is None:
            return None
        return cls(drawn, infill.ior, elastomer.design.inclusions.flake_reflectance)

    def on(self, infill: Any) -> Scatterers:
        """Where they are in the mesh of the cells as it is now.

        Args:
            infill: Its shape.
        """
        return self._now(infill)[0]

    def air_mm3(self, infill: Any) -> Array:
        """Volume of the bubbles in each cell, shape (cells, 1) [mm3].

        Args:
            infill: The shape of the cells.
        """
        return self._now(infill)[1]

    def _now(self, infill: Any) -> tuple[Scatterers, Array]:
        positions = mi.traverse(infill)["vertex_positions"]
        # Replaced vertices are another variable, and the one kept here stays alive.
        if self._state is None or self._positions.index != positions.index:
            placed = self._drawn.placed(np.array(positions, np.float64).reshape(-1, 3))
            scatterers = Scatterers.of(placed, self._drawn.cells, *self._optics)
            self._state = scatterers, placed.air_mm3(self._drawn.cells)[:, None]
            self._positions = mi.Float(positions)
        return self._state
