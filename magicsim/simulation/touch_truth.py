"""Ground truth of touch: forces on taxels, stretch and stress of the skin, shear of the infill."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from magicsim.arrays import Array
from magicsim.deform.contact.face import POINT_SPACING_MM
from magicsim.deform.deformation import Deformation
from magicsim.deform.lattice.relaxation import Branches
from magicsim.deform.lattice.structure import Lattice
from magicsim.deform.strain import InfillCells, SkinCells
from magicsim.deform.taxels import TaxelForces, TaxelGrid, TaxelMap
from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.scene import TaxelSettings

TOUCH_COLUMNS = (
    "taxel_force_n", "taxel_traction_mpa", "taxel_torque_nmm", "skin_stretch", "max_skin_stretch", "skin_von_mises_mpa",
    "max_skin_von_mises_mpa", "infill_shear", "max_infill_shear",
)  # fmt: skip
"""Names of all columns of touch in episodes and datasets, in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchFields:
    """What one state does to face, skin and infill; images have row 0 at +y and column 0 at -x."""

    forces: TaxelForces
    """Forces and torques of the taxels; they add up to those of the object."""
    skin_stretch: Array | None
    """Largest principal stretch of the skin below each taxel, 1 at rest, shape (rows, columns)."""
    skin_von_mises_mpa: Array | None
    """Largest von Mises stress of the skin below each taxel, shape (rows, columns) [MPa]."""
    infill_shear: Array | None
    """Largest shear of the infill below each taxel, of all layers of cells, 0 at rest, shape (rows, columns)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchTruth:
    """Fields of touch of one sensor, state by state."""

    taxels: TaxelMap
    skin: SkinCells | None
    infill: InfillCells | None

    @classmethod
    def of(
        cls, design: ElastomerDesign, lattice: Lattice, settings: TaxelSettings, *,
        point_spacing_mm: float = POINT_SPACING_MM, branches: Branches | None = None,
    ) -> Self:  # fmt: skip
        """Prepares a sensor."""
        grid = TaxelGrid.over(lattice, rows=settings.rows, columns=settings.columns)
        return cls(
            taxels=TaxelMap.of(lattice, grid, point_spacing_mm=point_spacing_mm),
            skin=SkinCells.of(design, lattice, branches=branches) if settings.skin else None,
            infill=InfillCells.of(design, lattice) if settings.infill else None,
        )

    def fields(self, deformation: Deformation) -> TouchFields:
        """All that was asked for of one state."""
        grid, stretch, stress, shear = self.taxels.grid, None, None, None
        if self.skin is not None:
            x, y = self.skin.lattice.planes_mm[:2]
            columns = self.skin.fields(deformation)
            stretch, stress = (grid.largest(x, y, each) for each in (columns.stretch, columns.von_mises_mpa))
        if self.infill is not None:
            x, y = (self.infill.grid.planes_mm(axis) for axis in (0, 1))
            shear = grid.largest(x, y, self.infill.shear(deformation).max(0))
        return TouchFields(
            forces=self.taxels.forces(deformation), skin_stretch=stretch, skin_von_mises_mpa=stress, infill_shear=shear
        )


def touch_columns(fields: TouchFields, settings: TaxelSettings) -> dict[str, npt.NDArray[np.floating[Any]] | float]:
    """Fields by the names of their columns in episodes and datasets.

    Forces are listed taxel by taxel, row by row, shape (rows * columns, 3); other fields are (rows, columns) of single
    precision, and each has its largest value under `max_...`.
    """
    name, load = "taxel_force_n", fields.forces.force_n
    if settings.unit == "MPa":
        name, load = "taxel_traction_mpa", fields.forces.traction_mpa
    found: dict[str, npt.NDArray[np.floating[Any]] | float] = {
        name: load.reshape(-1, 3), "taxel_torque_nmm": fields.forces.torque_nmm.reshape(-1, 3)
    }  # fmt: skip
    for each in ("skin_stretch", "skin_von_mises_mpa", "infill_shear"):
        image = getattr(fields, each)
        if image is not None:
            found |= {each: image.astype(np.float32), f"max_{each}": float(image.max())}
    return found
