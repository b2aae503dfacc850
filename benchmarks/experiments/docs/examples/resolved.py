"""What a lattice shows of dots that it does not resolve: forces, and what changes in the frame.

python benchmarks/experiments/docs/examples/resolved.py benchmarks/experiments/docs/resolved           # four minutes

A plate of 6 mm is pressed 0.8 mm deep, on the design's own lattice and on two finer ones, steep around the
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
CELLS_MM = (0.5, 1 / 3)
"""Asked sizes of lattice cells; with a quarter of a millimetre the finest dots take minutes to solve."""
STEEP = ("growth=3.0", "margin=0.5", "fine_depth=0.3")
SHOWN = (slice(85, 235), slice(45, 195))


def pressed(diameter_mm: float, cell_mm: float | None) -> tuple[dict[str, float | str], np.ndarray]:
    """Forces and seconds of one press, and the change of its frame around mid grey."""
    period_mm = 2 * diameter_mm
    plate = f'object={{kind="dots", radius_mm={diameter_mm / 2}, spacing_mm={period_mm}, size_mm=6.0}}'
    lattice = [] if cell_mm is None else [f"spacing_mm={cell_mm}", *STEEP]
    state = replace(UNTOUCHED, gap_mm=-DEPTH_MM)
    sensor = Sensor.for_scene(load_scene("pressed", [plate, *(f"design.lattice.{each}" for each in lattice)]))
    begin = time.perf_counter()
    dent = sensor.deform(state, sensor.rest)
    took_s = time.perf_counter() - begin
    rest, touched = sensor.radiance(UNTOUCHED, sensor.rest), sensor.radiance(state, dent)
    change = STRONGER * sensor.rig.camera.exposure_grey / rest.mean() * (touched - rest)
    x_mm = np.unique(sensor.lattice.nodes_mm[:, 0].round(6))
    row = {
        "diameter_mm": diameter_mm, "lattice": "design's" if cell_mm is None else "finer",
        "cell_in_the_middle_mm": round(float(np.diff(x_mm)[len(x_mm) // 2]), 3), "unknowns": dent.unknowns,
        "force_n": round(float(dent.force_n[2]), 3), "sideways_n": round(float(np.hypot(*dent.force_n[:2])), 3),
        "seconds": round(took_s, 1),
    }  # fmt: skip
    print(row, flush=True)
    return row, np.clip(128 + change, 0, 255)[SHOWN].astype(np.uint8)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    found = [[pressed(size, cell_mm) for cell_mm in (None, *CELLS_MM)] for size in DIAMETERS_MM]
    Image.fromarray(np.vstack([np.hstack([image for _, image in row]) for row in found])).save(out.with_suffix(".png"))
    with out.with_suffix(".csv").open("w", newline="") as file:
        table = csv.DictWriter(file, found[0][0][0], lineterminator="\n")
        table.writeheader()
        table.writerows(row for part in found for row, _ in part)
