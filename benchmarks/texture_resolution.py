"""How finely a lattice has to resolve a texture, and how much of it reaches the grid below the skin.

    python benchmarks/texture_resolution.py --out docs/benchmarks/texture-resolution.csv

A plate with lines is pressed into the default design on lattices of three to eight cells a period; the amplitude of the
pattern is that of the normal displacement at its own frequency, on the face and on the core's first plane, less that of
a plain plate of the same size. Below the
face of an incompressible half space it falls as (1 + k z) exp(-k z), k = 2 pi / spacing (plane strain, no shear on the
face); `half space` is that of a block without a grid, which the second design is.
"""

import argparse
import csv
import time
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.config.models import load_preset
from magicsim.errors import MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.sweep.mechanics import CentralPress, press_centrally
from magicsim.sweep.texture import LOOKED_AT_PERIODS, Pattern, plate

DESIGNS, SPACINGS_MM, CELLS, DEPTH_MM = ("mini-magictac", "uniform-block"), (2.0, 1.0, 0.6), (3, 4, 6, 8), 0.3
PATTERNS: tuple[Pattern | None, ...] = ("lines", None)
SKIN_MM, POINTS_A_PERIOD = 0.8, 24


def wave_mm(pressed: CentralPress, spacing_mm: float, below_mm: float) -> complex:
    """Normal displacement at the lines' frequency, so far below the face [mm]."""
    count = round(LOOKED_AT_PERIODS * POINTS_A_PERIOD)
    along = (np.arange(count) + 0.5 - count / 2) * spacing_mm / POINTS_A_PERIOD
    x, y = (each.ravel() for each in np.meshgrid(along, along))
    normal = pressed.displacements_mm(np.column_stack([x, y, np.full(x.shape, below_mm)]))[:, 2]
    return complex(2 * np.mean(normal * np.exp(2j * np.pi * x / spacing_mm)))


def rows() -> list[dict[str, Any]]:
    """Force and amplitudes of every design, spacing and lattice."""
    found = []
    for name in DESIGNS:
        design = load_preset(ElastomerDesign, "design", name, [])
        for spacing in SPACINGS_MM:
            decay = 2 * np.pi * SKIN_MM / spacing
            for cells in CELLS:
                start = time.process_time()
                row: dict[str, Any] = {"design": name, "spacing_mm": spacing, "cells": cells}
                try:
                    pressed, plain = (
                        press_centrally(
                            design, plate(each, spacing), DEPTH_MM, cells_across=1, spacing_mm=spacing / cells
                        )
                        for each in PATTERNS
                    )
                    face, core = (
                        abs(wave_mm(pressed, spacing, below) - wave_mm(plain, spacing, below))
                        for below in (0.0, SKIN_MM)
                    )
                    row |= {
                        "force_n": round(float(pressed.force_n[2]), 3), "face_um": round(1e3 * face, 2),
                        "core_um": round(1e3 * core, 3), "share": round(core / face, 4),
                        "half_space": round((1 + decay) * float(np.exp(-decay)), 4),
                        "nodes": len(pressed.lattice.nodes_mm),
                    }  # fmt: skip
                except MagicsimError as error:
                    row["failed"] = str(error)[:100]
                found.append(row | {"cpu_s": round(time.process_time() - start, 1)})
                print(found[-1], flush=True)
    return found


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    chosen, found = parser.parse_args(), rows()
    with chosen.out.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in found for key in row)), lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)


if __name__ == "__main__":
    main()
