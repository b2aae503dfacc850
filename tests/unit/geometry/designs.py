"""Designs to build in tests: the defaults with a few keys changed."""

from typing import Any

from magicsim.geometry.design import ElastomerDesign


def design(**changes: Any) -> ElastomerDesign:
    """A small block, 6 x 8 x 4.6 mm with cells of 0.8 mm, with some keys replaced."""
    body = {"youngs_modulus_mpa": 1.1, "poisson_ratio": 0.49, "ior": 1.49}
    infill = {"shear_modulus_mpa": 0.017, "bulk_modulus_mpa": 1000.0, "ior": 1.46, "sigma_s_per_mm": 0.3}
    data = {
        "schema_version": 1,
        "footprint_mm": (6.0, 8.0),
        "skin_mm": 0.8,
        "core_mm": 3.0,
        "cell_mm": 0.8,
        "wall_mm": 0.2,
        "materials": {"body": body, "infill": infill},
    }
    return ElastomerDesign.model_validate(data | changes)


EXTREMES = {
    "small cells": {"footprint_mm": (4.0, 3.2), "cell_mm": 0.3, "wall_mm": 0.1, "core_mm": 2.0},
    "large cells": {"footprint_mm": (24.0, 20.0), "cell_mm": 3.0, "wall_mm": 0.2, "core_mm": 9.6},
    "thin skin": {"skin_mm": 0.1, "core_mm": 2.0},
    "thick skin": {"footprint_mm": (14.0, 14.0), "skin_mm": 5.0, "core_mm": 4.0},
    "lowest": {"skin_mm": 0.1, "core_mm": 0.8, "cell_mm": 0.6, "footprint_mm": (4.0, 5.0)},
    "highest": {"footprint_mm": (8.0, 8.0), "skin_mm": 1.0, "core_mm": 23.0, "cell_mm": 1.8},
    "fine lattice": {"lattice": {"spacing_mm": 0.5}},
    "coarse lattice": {"lattice": {"spacing_mm": 3.0}},
}
"""Buildable designs at the edges of what is allowed, as changes to `design`."""
