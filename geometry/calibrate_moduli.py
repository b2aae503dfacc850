"""Fits the two unknown moduli of the printed materials to two published Shore A readings.

    python geometry/calibrate_moduli.py            # prints the moduli; some ten minutes on two cores

Readings (Fan, Li, Zhang, arXiv 2505.24382; see `magicsim.deform.durometer` for the test): blocks of 10 mm total height
with a skin of 3 mm read 33.25 A, with a skin of 0.5 mm 17.1 A. Unknown are the long-term Young's modulus of the body
(skin and walls, one material) and the shear modulus of the infill. Two readings, two unknowns: they are met, and every
other hardness is a prediction. The result is kept in `geometry/*.toml`.
"""

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from magicsim.config import load_preset
from magicsim.deform.durometer import durometer
from magicsim.geometry.design import ElastomerDesign

READINGS = (((10.0, 3.0), 33.25), ((10.0, 0.5), 17.1))
"""(Total height, skin) [mm] and Shore A."""
START = (1.6, 0.012)
"""Young's modulus of the body and shear modulus of the infill to start from [MPa]."""
TOLERANCE_A = 0.1
DIFFERENCE = 0.2
"""Step of the finite differences of the logarithms."""
MAX_UPDATES = 8


def sample(total_mm: float, skin_mm: float, moduli_mpa: tuple[float, float]) -> ElastomerDesign:
    """The default design with another height, skin and moduli."""
    body, infill = moduli_mpa
    return load_preset(
        ElastomerDesign, "design", "mini-magictac",
        [f"skin_mm={skin_mm}", f"core_mm={total_mm - 2 * skin_mm}", f"materials.body.youngs_modulus_mpa={body}",
         f"materials.infill.shear_modulus_mpa={infill}"],
    )  # fmt: skip


def reading(task: tuple[float, float, tuple[float, float], float, float]) -> float:
    """Shore A of one sample with some moduli, node spacing and friction."""
    total, skin, moduli, spacing, friction = task
    return durometer(sample(total, skin, moduli), spacing_mm=spacing, friction=friction).shore_a


def fit(pool: ProcessPoolExecutor, *, spacing_mm: float, friction: float) -> tuple[float, float]:
    """Moduli that meet the readings [MPa], by Broyden's method on their logarithms."""

    def misfit(logs: np.ndarray) -> np.ndarray:
        moduli = tuple(np.exp(logs).tolist())
        tasks = [(*size, moduli, spacing_mm, friction) for size, _ in READINGS]
        found = np.array(list(pool.map(reading, tasks)))
        sys.stderr.write(f"E = {moduli[0]:.5g}, infill {moduli[1]:.5g} MPa: {found.round(3).tolist()}\n")
        return found - [target for _, target in READINGS]

    logs = np.log(START)
    error = misfit(logs)
    slope = np.stack([(misfit(logs + DIFFERENCE * step) - error) / DIFFERENCE for step in np.eye(2)], axis=1)
    for _ in range(MAX_UPDATES):
        if np.abs(error).max() < TOLERANCE_A:
            return tuple(np.exp(logs).tolist())
        change = np.clip(-np.linalg.solve(slope, error), -0.7, 0.7)
        logs, before = logs + change, error
        error = misfit(logs)
        slope += np.outer(error - before - slope @ change, change) / (change @ change)
    msg = f"the fit did not meet the readings: {error.round(3).tolist()} off after {MAX_UPDATES} updates"
    raise RuntimeError(msg)


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spacing", type=float, default=0.3, help="node spacing under the cone [mm]")
    parser.add_argument("--friction", type=float, default=0.0, help="between tool and sample")
    options = parser.parse_args()
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        body, infill = fit(pool, spacing_mm=options.spacing, friction=options.friction)
    print(json.dumps({"youngs_modulus_mpa": body, "infill_shear_modulus_mpa": infill, **vars(options)}))


if __name__ == "__main__":
    main()
