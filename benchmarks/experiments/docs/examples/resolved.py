"""What a lattice shows of dots that it does not resolve: forces, and what changes in the frame.

python benchmarks/experiments/docs/examples/resolved.py benchmarks/experiments/docs/resolved           # four minutes

A plate of 6 mm is pressed 0.8 mm deep, on the design's own lattice and on some cells a period, steep around the
contact. OUT.csv has forces and seconds of the solution; OUT.png the change of each frame without the camera's noise.
"""

import argparse
import csv
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from magicsim import Sensor, load_scene
from magicsim.scenes.timeline import UNTOUCHED

DIAMETERS_MM, DEPTH_MM, STRONGER = (0.5, 1.0, 1.5), 0.8, 6
CELLS = {0.5: (2, 3), 1.0: (4, 6), 1.5: (4, 6)}
"""Cells a period: four of the finest dots take four minutes to solve."""
STEEP = ("growth=3.0", "margin=0.5", "fine_depth=0.3")
SHOWN = (slice(85, 235), slice(45, 195))


def pressed(diameter_mm: float, cells: int | None) -> tuple[dict[str, float | str], np.ndarray]:
    """Forces and seconds of one press, and the change of its frame around mid grey."""
    period_mm = 2 * diameter_mm
    plate = f'object={{kind="dots", radius_mm={diameter_mm / 2}, spacing_mm={period_mm}, size_mm=6.0}}'
    lattice = [] if cells is None else [f"spacing_mm={period_mm / cells}", *STEEP]
    state = replace(UNTOUCHED, gap_mm=-DEPTH_MM)
    sensor = Sensor.for_scene(load_scene("pressed", [plate, *(f"design.lattice.{each}" for each in lattice)]))
    begin = time.perf_counter()
    dent = sensor.deform(state, sensor.rest)
    took_s = time.perf_counter() - begin
    rest, touched = sensor.radiance(UNTOUCHED, sensor.rest), sensor.radiance(state, dent)
    change = STRONGER * sensor.rig.camera.exposure_grey / rest.mean() * (touched - rest)
    row = {
        "diameter_mm": diameter_mm, "cells_a_period": cells or "design's", "unknowns": dent.unknowns,
        "force_n": round(float(dent.force_n[2]), 3), "sideways_n": round(float(np.hypot(*dent.force_n[:2])), 3),
        "seconds": round(took_s, 1),
    }  # fmt: skip
    print(row, flush=True)
    return row, np.clip(128 + change, 0, 255)[SHOWN].astype(np.uint8)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    found = [[pressed(size, cells) for cells in (None, *CELLS[size])] for size in DIAMETERS_MM]
    Image.fromarray(np.vstack([np.hstack([image for _, image in row]) for row in found])).save(out.with_suffix(".png"))
    with out.with_suffix(".csv").open("w", newline="") as file:
        table = csv.DictWriter(file, found[0][0][0], lineterminator="\n")
        table.writeheader()
        table.writerows(row for part in found for row, _ in part)
