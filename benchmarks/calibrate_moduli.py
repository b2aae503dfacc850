"""Fits the two unknown moduli of the printed materials to two published Shore A readings.

    python benchmarks/calibrate_moduli.py --wall 0.1 0.15 0.2

Unknown are the long-term Young's modulus of the body (skin and walls, one material) and the shear modulus of the
infill; the thickness of the walls was never published, so the fit is made for each one asked for. Each reading is the
mean of one on a cell's centre and one where walls cross. Where no infill is soft enough for both rows, the body has
the stiffness with the smallest sum of squares at the softest infill, and what remains is written beside it.
"""

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from laboratory.hardness import READINGS, Setting, reading, workers

START = (1.6, 0.01)
"""Moduli to start from [MPa]."""
SOFTEST_MPA = 0.002
"""Of infill: half of the least that is plausible."""
TOLERANCE_A = 0.1
DIFFERENCE = 0.2
"""Step of the finite differences of the logarithms."""
MAX_UPDATES = 6


def misfits(pool: ProcessPoolExecutor, logs: np.ndarray, wall_mm: float) -> np.ndarray:
    """Shore A above the published readings."""
    body, infill = np.exp(logs).tolist()
    setting = Setting(body_mpa=body, infill_mpa=infill, wall_mm=wall_mm)
    jobs = [pool.submit(reading, *size, setting) for size in READINGS]
    found = [job.result() for job in jobs]
    sys.stderr.write(
        f"wall {wall_mm}: E = {body:.4g}, infill {infill:.4g} MPa: {[each['shore_a'] for each in found]}\n"
    )
    return np.array([each["shore_a"] for each in found]) - list(READINGS.values())


def fit(pool: ProcessPoolExecutor, wall_mm: float) -> dict[str, object]:
    """Moduli closest to the readings, by Broyden's method on their logarithms, the infill bounded below."""
    lowest = np.log([1e-3, SOFTEST_MPA])
    logs = np.log(START)
    error = misfits(pool, logs, wall_mm)
    slope = np.stack([(misfits(pool, logs + step, wall_mm) - error) / DIFFERENCE for step in DIFFERENCE * np.eye(2)], 1)
    for _ in range(MAX_UPDATES):
        change = np.clip(-np.linalg.solve(slope, error), -0.7, 0.7)
        if (logs + change)[1] < lowest[1]:  # softest infill, least squares in the body alone
            soft = lowest[1] - logs[1]
            change = np.array([-slope[:, 0] @ (error + slope[:, 1] * soft) / (slope[:, 0] @ slope[:, 0]), soft])
        if np.abs(error).max() < TOLERANCE_A or np.abs(change).max() < DIFFERENCE / 20:
            break
        logs, before = logs + change, error
        error = misfits(pool, logs, wall_mm)
        slope += np.outer(error - before - slope @ change, change) / (change @ change)
    body, infill = np.exp(logs).tolist()
    rows = {f"{total:g} mm, skin {skin:g} mm": off for (total, skin), off in zip(READINGS, error.tolist(), strict=True)}
    return {"wall_mm": wall_mm, "body_mpa": body, "infill_mpa": infill, "misfit_a": rows}


def main() -> None:
    """Writes one JSON object for each wall."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wall", type=float, nargs="+", default=[0.1, 0.15, 0.2], help="thickness of walls [mm]")
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("moduli.json"))
    options = parser.parse_args()
    with workers() as pool:
        fits = [fit(pool, wall_mm) for wall_mm in options.wall]
    options.out.write_text(json.dumps(fits, indent=1) + "\n")


if __name__ == "__main__":
    main()
