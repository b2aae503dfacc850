"""Shore A of printed samples, as the calibration and the predictions read it."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from magicsim.config.models import load_preset
from magicsim.deform.indentation.durometer import FRICTION, SPACING_MM, durometer
from magicsim.errors import MagicsimError
from magicsim.geometry.design import Base, ElastomerDesign, Mounting
from magicsim.geometry.grid import Place

READINGS = {(10.0, 3.0): 33.25, (10.0, 0.5): 17.1}
"""Published Shore A by total height and skin [mm] that the moduli are fitted to (Fan, Li, Zhang, arXiv 2505.24382)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is assumed of samples and test."""

    body_mpa: float
    """Long-term Young's modulus of skin and walls [MPa]."""
    infill_mpa: float
    """Shear modulus of the infill [MPa]."""
    infill_bulk_mpa: float = 1000.0
    """Bulk modulus of the infill [MPa]; the design's own, a liquid, unless it has voids."""
    wall_mm: float
    spacing_mm: float = SPACING_MM
    friction: float = FRICTION
    """Between tool and sample."""
    base: Base = "table"
    base_friction: float = Mounting().friction
    """Between sample and table; 0 is allowed here, where symmetry holds the sample."""

    @property
    def mounting(self) -> Mounting:
        """What the sample lies on."""
        return Mounting.model_construct(base=self.base, friction=self.base_friction)


def sample(total_mm: float, skin_mm: float, setting: Setting) -> ElastomerDesign:
    """The default design with another height, skin, wall and moduli."""
    return load_preset(
        ElastomerDesign, "design", "mini-magictac",
        [f"skin_mm={skin_mm}", f"core_mm={total_mm - 2 * skin_mm}", f"wall_mm={setting.wall_mm}",
         f"materials.body.youngs_modulus_mpa={setting.body_mpa}",
         f"materials.infill.shear_modulus_mpa={setting.infill_mpa}",
         f"materials.infill.bulk_modulus_mpa={setting.infill_bulk_mpa}"],
    )  # fmt: skip


def reading(
    total_mm: float, skin_mm: float, setting: Setting, places: Sequence[Place] = ("cell", "wall")
) -> dict[str, Any]:
    """Shore A at the centre of a cell, at a crossing of walls, and their mean; None, with reasons, where refused."""
    block, found = sample(total_mm, skin_mm, setting), dict[str, Any]()
    for place in places:
        try:
            result = durometer(
                block, spacing_mm=setting.spacing_mm, friction=setting.friction, place=place, mounting=setting.mounting
            )
            found[place] = result.shore_a
            found[f"{place}_min_jacobian"] = result.min_jacobian
            found[f"{place}_walls"] = result.walls
        except MagicsimError as error:
            found[place], found[f"{place}_refused"] = None, str(error)
    read = [found[place] for place in places if found[place] is not None]
    return {"shore_a": sum(read) / len(read) if read else None, **found}


@contextmanager
def workers() -> Iterator[ProcessPoolExecutor]:
    """One process per core with one thread each: the problems are too small for more."""
    os.environ |= dict.fromkeys(("MKL_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        yield pool
